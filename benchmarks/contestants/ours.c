/* The engine of this project, by its public header. */
#include <stdlib.h>
#include <string.h>

#include "contestant.h"
#include "ourtree.h"

typedef struct Ours {
  const Scene* scene;
  ctChainTree* tree;
  ctCounts counts;
  int turnCount; /* of the last test of the whole chain */
  Turn turns[MOST_TURNS];
} Ours;

static void destroy(void* self) {
  Ours* ours = self;
  if (ours != NULL) {
    ctDestroy(ours->tree);
    free(ours);
  }
}

/* Takes over a tree, which is NULL if there was no memory. */
static void* makeOf(const Scene* scene, ctChainTree* tree) {
  Ours* ours = calloc(1, sizeof *ours);
  if (ours == NULL || tree == NULL) {
    ctDestroy(tree);
    free(ours);
    return NULL;
  }
  ours->scene = scene;
  ours->tree = tree;
  return ours;
}

static void* make(const Scene* scene) {
  return makeOf(scene, ourTreeOf(scene, scene->exclusionCount, 0, NULL));
}

static void* makeAvx512(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_SIMD", "avx512"));
}

static void* makeAvx2(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_SIMD", "avx2"));
}

static void* makePortable(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_SIMD", "portable"));
}

static void* makeTree(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_TRIALS", "tree"));
}

static void* makeBoxes(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_TRIALS", "boxes"));
}

static void* makeClearances(const Scene* scene) {
  return makeOf(scene, ourTreeWith(scene, "CHAINTREE_TRIALS", "clearances"));
}

static bool propose(Ours* ours, int count, const Turn* turns, double sign) {
  ctChange changes[MOST_TURNS];
  for (int i = 0; i < count; i++) {
    changes[i].link = ours->scene->torsions[turns[i].torsion].link;
    changes[i].angle = sign * turns[i].angle;
  }
  return ctPropose(ours->tree, count, changes) == ctSuccess;
}

static int test(void* self, int count, const Turn* turns) {
  Ours* ours = self;
  bool clash = false;
  const bool success =
      propose(ours, count, turns, 1) && ctTestTrial(ours->tree, &clash, NULL, &ours->counts) == ctSuccess;
  return success ? clash : -1;
}

static bool accept(void* self) {
  Ours* ours = self;
  return ctAccept(ours->tree, &ours->counts) == ctSuccess;
}

static void reject(void* self) {
  Ours* ours = self;
  ctReject(ours->tree);
}

static int testAll(void* self) {
  Ours* ours = self;
  bool clash = false;
  return ctHasClash(ours->tree, &clash, NULL, &ours->counts) == ctSuccess ? clash : -1;
}

/* ---- The whole chain after a turn, which is taken back if need be ---- */

static int testWhole(void* self, int count, const Turn* turns) {
  Ours* ours = self;
  memcpy(ours->turns, turns, (size_t)count * sizeof *turns);
  ours->turnCount = count;
  return propose(ours, count, turns, 1) && accept(self) ? testAll(self) : -1;
}

static bool acceptWhole(void* self) {
  (void)self;
  return true;
}

static void rejectWhole(void* self) {
  Ours* ours = self;
  if (propose(ours, ours->turnCount, ours->turns, -1)) {
    accept(self);
  }
}

/* ---- The contestants ---- */

static Counts counts(const void* self) {
  const ctCounts* counted = &((const Ours*)self)->counts;
  return (Counts){counted->volumeTests, counted->particleTests, counted->nodesUpdated};
}

static void positions(void* self, double* coordinates) {
  ctGetPositions(((Ours*)self)->tree, coordinates);
}

static const char* instructionSet(const void* self) {
  return ctGetInstructionSet(((const Ours*)self)->tree);
}

#define OURS(itsName, itsIdea, itsMake)                                                                              \
  {                                                                                                                  \
    .name = itsName, .idea = itsIdea, .make = itsMake, .destroy = destroy, .test = test, .accept = accept,           \
    .reject = reject, .testAll = testAll, .counts = counts, .positions = positions, .instructionSet = instructionSet \
  }

const Contestant contestantOurs = OURS("ours", "the engine of this project", make);

/* Each path that it can take. */
const Contestant contestantOursAvx512 = OURS("ours-avx512", "the engine with AVX-512", makeAvx512);
const Contestant contestantOursAvx2 = OURS("ours-avx2", "the engine with AVX2", makeAvx2);
const Contestant contestantOursPortable = OURS("ours-portable", "the engine in plain C", makePortable);
const Contestant contestantOursTree = OURS("ours-tree", "the engine by its tree of spheres", makeTree);
const Contestant contestantOursBoxes = OURS("ours-boxes", "the engine by its tree with oriented boxes", makeBoxes);
const Contestant contestantOursClearances = OURS("ours-clearances", "the engine by its clearances", makeClearances);
const Contestant contestantOursWhole = {.name = "ours-whole",
                                        .idea = "the engine, asked about the whole chain",
                                        .make = make,
                                        .destroy = destroy,
                                        .test = testWhole,
                                        .accept = acceptWhole,
                                        .reject = rejectWhole,
                                        .counts = counts,
                                        .positions = positions,
                                        .instructionSet = instructionSet};
