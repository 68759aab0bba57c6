/* The engine of this project, by its public header. */
#include <stdlib.h>

#include "contestant.h"
#include "ourtree.h"

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

static void* make(const Scene* scene) {
  Ours* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  ours->scene = scene;
  ours->tree = ourTreeOf(scene, scene->exclusionCount, 0, NULL);
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

static const char* instructionSet(const void* self) {
  return ctGetInstructionSet(((const Ours*)self)->tree);
}

const Contestant contestantOurs = {.name = "ours",
                                   .idea = "the engine of this project",
                                   .make = make,
                                   .destroy = destroy,
                                   .test = test,
                                   .accept = accept,
                                   .reject = reject,
                                   .testAll = testAll,
                                   .counts = counts,
                                   .instructionSet = instructionSet};
