#include "scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Sources ---- */

static void* allocate(int count, size_t size) {
  return calloc(count > 0 ? (size_t)count : 1, size);
}

bool sceneSourceInit(SceneSource* source, int particleCount, int linkCount, int exclusionCount) {
  source->particleCount = particleCount;
  source->spheres = allocate(particleCount, sizeof *source->spheres);
  source->particleLinks = allocate(particleCount, sizeof *source->particleLinks);
  source->linkCount = linkCount;
  source->links = allocate(linkCount, sizeof *source->links);
  source->exclusionCount = exclusionCount;
  source->exclusions = allocate(exclusionCount, sizeof *source->exclusions);
  if (source->spheres == NULL || source->particleLinks == NULL || source->links == NULL || source->exclusions == NULL) {
    sceneSourceFree(source);
    return false;
  }
  return true;
}

void sceneSourceFree(SceneSource* source) {
  free(source->spheres);
  free(source->particleLinks);
  free(source->links);
  free(source->exclusions);
  *source = (SceneSource){0};
}

/* ---- Checks ---- */

static bool fail(char* error, size_t size, const char* format, ...) __attribute__((format(printf, 3, 4)));

static bool fail(char* error, size_t size, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(error, size, format, arguments);
  va_end(arguments);
  return false;
}

static bool outOfRange(int index, int count) {
  return index < 0 || index >= count;
}

static bool checkParticles(const SceneSource* source, char* error, size_t size) {
  for (int i = 0; i < source->particleCount; i++) {
    const Sphere* sphere = &source->spheres[i];
    if (!isfinite(sphere->x[0]) || !isfinite(sphere->x[1]) || !isfinite(sphere->x[2])) {
      return fail(error, size, "particle %d has a position that is not finite", i);
    }
    if (!(sphere->radius > 0) || !isfinite(sphere->radius)) {
      return fail(error, size, "particle %d has no positive radius", i);
    }
    if (outOfRange(source->particleLinks[i], source->linkCount)) {
      return fail(error, size, "particle %d is of link %d, which is not there", i, source->particleLinks[i]);
    }
  }
  return true;
}

static bool checkLinks(const SceneSource* source, char* error, size_t size) {
  for (int link = 0; link < source->linkCount; link++) {
    const SourceLink* l = &source->links[link];
    if (l->parent == -1) {
      continue;
    }
    if (outOfRange(l->parent, source->linkCount)) {
      return fail(error, size, "link %d hangs on link %d, which is not there", link, l->parent);
    }
    if (outOfRange(l->axis[0], source->particleCount) || outOfRange(l->axis[1], source->particleCount) ||
        source->particleLinks[l->axis[0]] != l->parent || source->particleLinks[l->axis[1]] != link) {
      return fail(error, size, "the axis of link %d does not lead from a particle of its parent to one of its own",
                  link);
    }
  }
  return true;
}

static bool checkExclusions(const SceneSource* source, char* error, size_t size) {
  for (int k = 0; k < source->exclusionCount; k++) {
    const int* pair = source->exclusions[k];
    if (outOfRange(pair[0], source->particleCount) || outOfRange(pair[1], source->particleCount)) {
      return fail(error, size, "exclusion %d names a particle that is not there", k);
    }
  }
  return true;
}

/* ---- The walk over the links ---- */

typedef struct Walk {
  int* order;      /* of the links */
  int* weights;    /* particles in a link and all that hangs on it */
  int* firstChild; /* and the siblings behind it, ending with -1 */
  int* nextSibling;
  int* stack;
} Walk;

static bool walkInit(Walk* walk, int linkCount) {
  walk->order = allocate(linkCount, sizeof(int));
  walk->weights = allocate(linkCount, sizeof(int));
  walk->firstChild = allocate(linkCount, sizeof(int));
  walk->nextSibling = allocate(linkCount, sizeof(int));
  walk->stack = allocate(linkCount, sizeof(int));
  return walk->order != NULL && walk->weights != NULL && walk->firstChild != NULL && walk->nextSibling != NULL &&
         walk->stack != NULL;
}

static void walkFree(Walk* walk) {
  free(walk->order);
  free(walk->weights);
  free(walk->firstChild);
  free(walk->nextSibling);
  free(walk->stack);
}

static void listChildren(Walk* walk, const SceneSource* source) {
  memset(walk->firstChild, -1, (size_t)source->linkCount * sizeof(int));
  for (int link = source->linkCount - 1; link >= 0; link--) {
    const int parent = source->links[link].parent;
    if (parent != -1) {
      walk->nextSibling[link] = walk->firstChild[parent];
      walk->firstChild[parent] = link;
    }
  }
}

/* Visits all links, the heaviest child last; returns how many it came by, fewer than there are if they form a ring. */
static int visit(Walk* walk, const SceneSource* source) {
  int visited = 0;
  for (int root = 0; root < source->linkCount; root++) {
    if (source->links[root].parent != -1) {
      continue;
    }
    int depth = 0;
    walk->stack[depth++] = root;
    while (depth > 0) {
      const int link = walk->stack[--depth];
      walk->order[visited++] = link;
      int heaviest = walk->firstChild[link];
      for (int child = heaviest; child != -1; child = walk->nextSibling[child]) {
        heaviest = walk->weights[child] >= walk->weights[heaviest] ? child : heaviest;
      }
      if (heaviest != -1) {
        walk->stack[depth++] = heaviest;
      }
      for (int child = walk->firstChild[link]; child != -1; child = walk->nextSibling[child]) {
        if (child != heaviest) {
          walk->stack[depth++] = child;
        }
      }
    }
  }
  return visited;
}

static bool orderLinks(Walk* walk, const SceneSource* source, char* error, size_t size) {
  listChildren(walk, source);
  if (visit(walk, source) < source->linkCount) {
    return fail(error, size, "some links hang on each other in a ring");
  }
  for (int i = 0; i < source->particleCount; i++) {
    walk->weights[source->particleLinks[i]]++;
  }
  for (int k = source->linkCount - 1; k >= 0; k--) {
    const int link = walk->order[k];
    if (source->links[link].parent != -1) {
      walk->weights[source->links[link].parent] += walk->weights[link];
    }
  }
  visit(walk, source);
  return true;
}

/* ---- The scene ---- */

static Scene* sceneAllocate(const SceneSource* source) {
  Scene* scene = calloc(1, sizeof *scene);
  if (scene == NULL) {
    return NULL;
  }
  scene->particleCount = source->particleCount;
  scene->spheres = allocate(source->particleCount, sizeof *scene->spheres);
  scene->particleLinks = allocate(source->particleCount, sizeof(int));
  scene->particleNames = allocate(source->particleCount, sizeof(int));
  scene->linkCount = source->linkCount;
  scene->linkParents = allocate(source->linkCount, sizeof(int));
  scene->torsions = allocate(source->linkCount, sizeof *scene->torsions);
  scene->exclusionCount = source->exclusionCount;
  scene->exclusions = allocate(source->exclusionCount, sizeof *scene->exclusions);
  scene->exclusionBegin = allocate(source->particleCount + 2, sizeof(int));
  scene->excluded = allocate(2 * source->exclusionCount, sizeof(int));
  if (scene->spheres == NULL || scene->particleLinks == NULL || scene->particleNames == NULL ||
      scene->linkParents == NULL || scene->torsions == NULL || scene->exclusions == NULL ||
      scene->exclusionBegin == NULL || scene->excluded == NULL) {
    sceneFree(scene);
    return NULL;
  }
  return scene;
}

/* `newIndex` of each particle of the source, by the new order of its link. */
static void placeParticles(Scene* scene, const SceneSource* source, const int* linkRank, int* linkBegin,
                           int* newIndex) {
  for (int i = 0; i < source->particleCount; i++) {
    linkBegin[linkRank[source->particleLinks[i]] + 1]++;
  }
  for (int k = 0; k < source->linkCount; k++) {
    linkBegin[k + 1] += linkBegin[k];
  }
  for (int i = 0; i < source->particleCount; i++) {
    const int rank = linkRank[source->particleLinks[i]];
    const int place = linkBegin[rank]++;
    newIndex[i] = place;
    scene->spheres[place] = source->spheres[i];
    scene->particleLinks[place] = rank;
    scene->particleNames[place] = i;
  }
  for (int k = source->linkCount; k > 0; k--) {
    linkBegin[k] = linkBegin[k - 1];
  }
  linkBegin[0] = 0;
}

static void placeTorsions(Scene* scene, const SceneSource* source, const Walk* walk, const int* linkRank,
                          const int* linkBegin, const int* newIndex) {
  for (int k = 0; k < source->linkCount; k++) {
    const int link = walk->order[k];
    const SourceLink* l = &source->links[link];
    scene->linkParents[k] = l->parent == -1 ? -1 : linkRank[l->parent];
    if (l->parent != -1) {
      scene->torsions[scene->torsionCount++] = (Torsion){.axis = {newIndex[l->axis[0]], newIndex[l->axis[1]]},
                                                         .first = linkBegin[k],
                                                         .last = linkBegin[k] + walk->weights[link],
                                                         .link = k,
                                                         .sideChain = l->sideChain};
    }
  }
}

static void placeExclusions(Scene* scene, const SceneSource* source, const int* newIndex) {
  int* begin = scene->exclusionBegin;
  for (int k = 0; k < source->exclusionCount; k++) {
    for (int side = 0; side < 2; side++) {
      scene->exclusions[k][side] = newIndex[source->exclusions[k][side]];
      begin[scene->exclusions[k][side] + 2]++;
    }
  }
  for (int i = 0; i < source->particleCount; i++) {
    begin[i + 1] += begin[i];
  }
  for (int k = 0; k < source->exclusionCount; k++) {
    for (int side = 0; side < 2; side++) {
      scene->excluded[begin[scene->exclusions[k][side] + 1]++] = scene->exclusions[k][1 - side];
    }
  }
}

static bool fill(Scene* scene, const SceneSource* source, Walk* walk, char* error, size_t size) {
  int* linkRank = allocate(source->linkCount, sizeof(int));
  int* linkBegin = allocate(source->linkCount + 1, sizeof(int));
  int* newIndex = allocate(source->particleCount, sizeof(int));
  const bool allocated = linkRank != NULL && linkBegin != NULL && newIndex != NULL;
  bool success = allocated || fail(error, size, "not enough memory");
  success = success && orderLinks(walk, source, error, size);
  if (success) {
    for (int k = 0; k < source->linkCount; k++) {
      linkRank[walk->order[k]] = k;
    }
    placeParticles(scene, source, linkRank, linkBegin, newIndex);
    placeTorsions(scene, source, walk, linkRank, linkBegin, newIndex);
    placeExclusions(scene, source, newIndex);
  }
  free(linkRank);
  free(linkBegin);
  free(newIndex);
  return success;
}

Scene* sceneMake(const SceneSource* source, char* error, size_t size) {
  if (!checkParticles(source, error, size) || !checkLinks(source, error, size) ||
      !checkExclusions(source, error, size)) {
    return NULL;
  }
  Walk walk = {0};
  Scene* scene = sceneAllocate(source);
  bool success = (walkInit(&walk, source->linkCount) && scene != NULL) || fail(error, size, "not enough memory");
  success = success && fill(scene, source, &walk, error, size);
  walkFree(&walk);
  if (!success) {
    sceneFree(scene);
    return NULL;
  }
  return scene;
}

void sceneFree(Scene* scene) {
  if (scene == NULL) {
    return;
  }
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

double sceneLargestRadius(const Scene* scene) {
  double largest = 0;
  for (int i = 0; i < scene->particleCount; i++) {
    largest = fmax(largest, scene->spheres[i].radius);
  }
  return largest;
}
