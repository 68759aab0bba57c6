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

static void* makeOf(const Scene* scene, ctChainTree* tree) {
  Ours* ours = allocate(1, sizeof *ours);
  ours->scene = scene;
  ours->tree = tree;
  return ours;
}

static void* make(const Scene* scene) {
  return makeOf(scene, ourTreeOf(scene, scene->exclusionCount));
}

static void* makeWith(const Scene* scene, const char* variable, const char* value) {
  return makeOf(scene, ourTreeWith(scene, variable, value, NULL, NULL, NULL, 0));
}

static void* makeTree(const Scene* scene) {
  return makeWith(scene, "CHAINTREE_TRIALS", "tree");
}

static void* makeBoxes(const Scene* scene) {
  return makeWith(scene, "CHAINTREE_TRIALS", "boxes");
}

static void* makeClearances(const Scene* scene) {
  return makeWith(scene, "CHAINTREE_TRIALS", "clearances");
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

#define OURS(itsName, itsIdea, itsMake)                                                                    \
  {                                                                                                        \
    .name = itsName, .idea = itsIdea, .make = itsMake, .destroy = destroy, .test = test, .accept = accept, \
    .reject = reject, .counts = counts, .instructionSet = instructionSet                                   \
  }

const Contestant contestantOurs = OURS("ours", "the engine of this project", make);
const Contestant contestantOursTree = OURS("ours-tree", "the engine by its tree of spheres", makeTree);
const Contestant contestantOursBoxes = OURS("ours-boxes", "the engine by its tree with oriented boxes", makeBoxes);
const Contestant contestantOursClearances = OURS("ours-clearances", "the engine by its clearances", makeClearances);
