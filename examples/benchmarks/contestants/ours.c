/* The engine of this project, by its public header. */
#include <stdint.h>
#include <stdlib.h>

#include "chaintree.h"
#include "contestant.h"

typedef struct Ours {
  const Scene* scene;
  ctChainTree* tree;
  ctCounts counts;
} Ours;

static void destroy(void* self) {
  Ours* ours = self;
  if (ours != NULL) {
    ctDestroy(ours->tree);
    free(ours);
  }
}

static ctChainTree* makeTree(const Scene* scene) {
  const size_t particles = (size_t)scene->particleCount;
  const size_t links = (size_t)scene->linkCount;
  double* positions = malloc(3 * particles * sizeof(double) + 1);
  double* radii = malloc(particles * sizeof(double) + 1);
  uint8_t* joints = malloc(links + 1);
  int(*torsions)[4] = calloc(links + 1, sizeof *torsions);
  ctChainTree* tree = NULL;
  if (positions != NULL && radii != NULL && joints != NULL && torsions != NULL) {
    for (size_t i = 0; i < particles; i++) {
      for (size_t k = 0; k < 3; k++) {
        positions[3 * i + k] = scene->spheres[i].x[k];
      }
      radii[i] = scene->spheres[i].radius;
    }
    for (size_t link = 0; link < links; link++) {
      joints[link] = scene->linkParents[link] < 0 ? ctFreeJoint : ctTorsionJoint;
    }
    for (int t = 0; t < scene->torsionCount; t++) {
      const Torsion* torsion = &scene->torsions[t];
      torsions[torsion->link][0] = torsion->axis[0];
      torsions[torsion->link][1] = torsion->axis[0];
      torsions[torsion->link][2] = torsion->axis[1];
      torsions[torsion->link][3] = torsion->axis[1];
    }
    const ctDefinition definition = {.particleCount = scene->particleCount,
                                     .positions = positions,
                                     .radii = radii,
                                     .particleLinks = scene->particleLinks,
                                     .linkCount = scene->linkCount,
                                     .linkParents = scene->linkParents,
                                     .linkJoints = joints,
                                     .linkTorsions = (const int(*)[4])torsions,
                                     .exclusionCount = scene->exclusionCount,
                                     .exclusions = (const int(*)[2])scene->exclusions};
    ctCreate(&definition, &tree, NULL, 0);
  }
  free(positions);
  free(radii);
  free(joints);
  free(torsions);
  return tree;
}

static void* make(const Scene* scene) {
  Ours* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  ours->scene = scene;
  ours->tree = makeTree(scene);
  if (ours->tree == NULL) {
    destroy(ours);
    return NULL;
  }
  return ours;
}

static int test(void* self, int count, const Turn* turns) {
  Ours* ours = self;
  ctChange changes[MOST_TURNS];
  for (int i = 0; i < count; i++) {
    changes[i].link = ours->scene->torsions[turns[i].torsion].link;
    changes[i].angle = turns[i].angle;
  }
  bool clash = false;
  const bool success = ctPropose(ours->tree, count, changes) == ctSuccess &&
                       ctTestTrial(ours->tree, &clash, NULL, &ours->counts) == ctSuccess;
  return success ? clash : -1;
}

static bool accept(void* self) {
  Ours* ours = self;
  return ctCommit(ours->tree, &ours->counts) == ctSuccess;
}

static void reject(void* self) {
  Ours* ours = self;
  ctDiscard(ours->tree);
}

static int testAll(void* self) {
  Ours* ours = self;
  bool clash = false;
  return ctHasClash(ours->tree, &clash, NULL, &ours->counts) == ctSuccess ? clash : -1;
}

static Counts counts(const void* self) {
  const ctCounts* counted = &((const Ours*)self)->counts;
  return (Counts){counted->volumeTests, counted->particleTests, counted->nodesUpdated};
}

const Contestant contestantOurs = {.name = "ours",
                                   .idea = "the engine of this project",
                                   .make = make,
                                   .destroy = destroy,
                                   .test = test,
                                   .accept = accept,
                                   .reject = reject,
                                   .testAll = testAll,
                                   .counts = counts};
