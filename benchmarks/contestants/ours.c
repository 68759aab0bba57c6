/* The engine of this project, by its public header. */
#include "contestant.h"
#include "ourtree.h"

typedef struct Ours {
  const Scene* scene;
  ctChainTree* tree;
  ctCounts counts;
} Ours;

static void destroy(void* self) {
  ctDestroy(((Ours*)self)->tree);
  free(self);
}

static void* make(const Scene* scene) {
  Ours* ours = allocate(1, sizeof *ours);
  ours->scene = scene;
  ours->tree = ourTreeOf(scene, scene->exclusionCount);
  return ours;
}

static bool test(void* self, int count, const Turn* turns) {
  Ours* ours = self;
  ctChange changes[MOST_TURNS];
  for (int i = 0; i < count; i++) {
    changes[i].link = ours->scene->torsions[turns[i].torsion].link;
    changes[i].angle = turns[i].angle;
  }
  bool clash = false;
  ourCheck(ctPropose(ours->tree, count, changes));
  ourCheck(ctTestTrial(ours->tree, &clash, NULL, &ours->counts));
  return clash;
}

static void accept(void* self) {
  Ours* ours = self;
  ourCheck(ctAccept(ours->tree, &ours->counts));
}

static void reject(void* self) {
  ctReject(((Ours*)self)->tree);
}

static Counts counts(const void* self) {
  const ctCounts* counted = &((const Ours*)self)->counts;
  return (Counts){counted->volumeTests, counted->particleTests};
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
                                   .counts = counts,
                                   .instructionSet = instructionSet};
