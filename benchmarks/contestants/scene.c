#include "scene.h"

#include <math.h>

#include "memory.h"

Scene* sceneAllocate(int particleCount, int linkCount, int exclusionCount) {
  Scene* scene = allocate(1, sizeof *scene);
  scene->particleCount = particleCount;
  scene->spheres = allocate(particleCount, sizeof *scene->spheres);
  scene->particleLinks = allocate(particleCount, sizeof(int));
  scene->particleNames = allocate(particleCount, sizeof(int));
  scene->linkCount = linkCount;
  scene->linkParents = allocate(linkCount, sizeof(int));
  scene->torsions = allocate(linkCount, sizeof *scene->torsions);
  scene->exclusionCount = exclusionCount;
  scene->exclusions = allocate(exclusionCount, sizeof *scene->exclusions);
  scene->exclusionBegin = allocate(particleCount + 2, sizeof(int));
  scene->excluded = allocate(2 * exclusionCount, sizeof(int));
  return scene;
}

void sceneFree(Scene* scene) {
  free(scene->spheres);
  free(scene->particleLinks);
  free(scene->particleNames);
  free(scene->linkParents);
  free(scene->torsions);
  free(scene->exclusions);
  free(scene->exclusionBegin);
  free(scene->excluded);
  free(scene);
}

void sceneIndexExclusions(Scene* scene) {
  int* begin = scene->exclusionBegin;
  for (int k = 0; k < scene->exclusionCount; k++) {
    begin[scene->exclusions[k][0] + 2]++;
    begin[scene->exclusions[k][1] + 2]++;
  }
  for (int i = 0; i < scene->particleCount; i++) {
    begin[i + 1] += begin[i];
  }
  for (int k = 0; k < scene->exclusionCount; k++) {
    for (int side = 0; side < 2; side++) {
      scene->excluded[begin[scene->exclusions[k][side] + 1]++] = scene->exclusions[k][1 - side];
    }
  }
}

double sceneLargestRadius(const Scene* scene) {
  double largest = 0;
  for (int i = 0; i < scene->particleCount; i++) {
    largest = fmax(largest, scene->spheres[i].radius);
  }
  return largest;
}

/* ---- Reading ---- */

static bool readAll(FILE* file, Scene* scene) {
  for (int i = 0; i < scene->particleCount; i++) {
    Sphere* sphere = &scene->spheres[i];
    if (fscanf(file, "%lf %lf %lf %lf %d %d", &sphere->x[0], &sphere->x[1], &sphere->x[2], &sphere->radius,
               &scene->particleLinks[i], &scene->particleNames[i]) != 6) {
      return false;
    }
  }
  for (int link = 0; link < scene->linkCount; link++) {
    Torsion torsion = {.link = link};
    int side;
    if (fscanf(file, "%d %d %d %d %d %d", &scene->linkParents[link], &torsion.axis[0], &torsion.axis[1], &torsion.first,
               &torsion.last, &side) != 6) {
      return false;
    }
    if (scene->linkParents[link] >= 0) {
      torsion.sideChain = side != 0;
      scene->torsions[scene->torsionCount++] = torsion;
    }
  }
  for (int k = 0; k < scene->exclusionCount; k++) {
    int* pair = scene->exclusions[k];
    if (fscanf(file, "%d %d", &pair[0], &pair[1]) != 2 || pair[0] < 0 || pair[0] >= scene->particleCount ||
        pair[1] < 0 || pair[1] >= scene->particleCount) {
      return false;
    }
  }
  sceneIndexExclusions(scene);
  return true;
}

Scene* sceneRead(const char* path, char* error, size_t size) {
  int version = 0;
  int counts[3] = {0, 0, 0};
  Scene* scene = NULL;
  FILE* file = fopen(path, "r");
  if (file == NULL) {
    snprintf(error, size, "%s cannot be read", path);
    return NULL;
  }
  if (fscanf(file, "chaintree-scene %d particles %d links %d exclusions %d", &version, &counts[0], &counts[1],
             &counts[2]) == 4 &&
      version == 2 && counts[0] > 0 && counts[1] > 0 && counts[2] >= 0) {
    scene = sceneAllocate(counts[0], counts[1], counts[2]);
    if (!readAll(file, scene)) {
      sceneFree(scene);
      scene = NULL;
    }
  }
  fclose(file);
  if (scene == NULL) {
    snprintf(error, size, "%s is no scene, or ends early", path);
  }
  return scene;
}
