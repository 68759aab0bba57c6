#include "scenefile.h"

#include <stdio.h>
#include <string.h>

static bool readParticles(FILE* file, SceneSource* source) {
  for (int i = 0; i < source->particleCount; i++) {
    Sphere* sphere = &source->spheres[i];
    if (fscanf(file, "%lf %lf %lf %lf %d", &sphere->x[0], &sphere->x[1], &sphere->x[2], &sphere->radius,
               &source->particleLinks[i]) != 5) {
      return false;
    }
  }
  return true;
}

static bool readLinks(FILE* file, SceneSource* source) {
  for (int i = 0; i < source->linkCount; i++) {
    SourceLink* link = &source->links[i];
    int side;
    if (fscanf(file, "%d %d %d %d", &link->parent, &link->axis[0], &link->axis[1], &side) != 4) {
      return false;
    }
    link->sideChain = side != 0;
  }
  return true;
}

static bool readExclusions(FILE* file, SceneSource* source) {
  for (int i = 0; i < source->exclusionCount; i++) {
    if (fscanf(file, "%d %d", &source->exclusions[i][0], &source->exclusions[i][1]) != 2) {
      return false;
    }
  }
  return true;
}

static Scene* readScene(FILE* file, const char* path, char* error, size_t size) {
  int version = 0;
  int particles = -1;
  int links = -1;
  int exclusions = -1;
  if (fscanf(file, "chaintree-scene %d particles %d links %d exclusions %d", &version, &particles, &links,
             &exclusions) != 4 ||
      version != 1 || particles < 1 || links < 1 || exclusions < 0) {
    snprintf(error, size, "%s does not begin as a scene does", path);
    return NULL;
  }
  SceneSource source;
  if (!sceneSourceInit(&source, particles, links, exclusions)) {
    snprintf(error, size, "not enough memory for %s", path);
    return NULL;
  }
  Scene* scene = NULL;
  if (!readParticles(file, &source) || !readLinks(file, &source) || !readExclusions(file, &source)) {
    snprintf(error, size, "%s ends early, or holds what is no number", path);
  } else {
    char fault[256];
    scene = sceneMake(&source, fault, sizeof fault);
    if (scene == NULL) {
      snprintf(error, size, "%s: %s", path, fault);
    }
  }
  sceneSourceFree(&source);
  return scene;
}

Scene* sceneRead(const char* path, char* error, size_t size) {
  if (strcmp(path, "-") == 0) {
    return readScene(stdin, "the standard input", error, size);
  }
  FILE* file = fopen(path, "r");
  if (file == NULL) {
    snprintf(error, size, "%s cannot be read", path);
    return NULL;
  }
  Scene* scene = readScene(file, path, error, size);
  fclose(file);
  return scene;
}
