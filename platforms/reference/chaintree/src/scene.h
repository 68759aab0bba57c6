/* The scene behind a handle, and the tolerances of pairs, which trials and queries share. */
#ifndef CT_SCENE_H_
#define CT_SCENE_H_

#include "clearance.h"
#include "leaves.h"
#include "merged.h"
#include "position.h"
#include "recentclashes.h"
#include "sweep.h"
#include "tester.h"
#include "trial.h"

struct ctChainTree {
  Arena arena;
  Sequence sequence;
  Exclusions exclusions;
  Limits limits;
  Tree ownTree; /* content may be outdated: use ctSceneTree; layout, wide functions and revision are always right */
  World world;
  Traversal traversal;
  bool isTesterOff[TESTER_COUNT]; /* by TesterId */
  Clearance clearance;
  RecentClashes recentClashes;
  Merged merged;
  Sweep ownSweep; /* snapshot may be outdated: use ctSceneSweep */
  Trial trials[2];
  /* These two are swapped at once: within a line of the processor's cache, which every trial would wait for otherwise.
   */
  _Alignas(16) Trial* trial; /* that is open, if one is */
  Trial* next;               /* scratch of ctPropose: one that fails leaves the open trial alone */
  int64_t trialCount;
  Copied followed; /* the array of ctFollowPositions and ctFollowTrialPositions */
  SlotPairs ties;
  Leaves leaves;           /* may be outdated */
  int64_t changeCount;     /* of the state */
  int64_t acceptedCount;   /* of these, by trials */
  ctSelection* selections; /* not freed yet */
  double overlapTolerance;
  double hydrogenBondAllowance;
  char errorText[200];
};

/* Keeps the sentence for ctGetErrorText and returns the status. */
ctStatus ctFail(ctChainTree* scene, ctStatus status, const char* format, ...) __attribute__((format(printf, 3, 4)));
ctStatus ctFailOutOfMemory(ctChainTree* scene);
ctStatus ctFailNoTrial(ctChainTree* scene);

/* Fails because the scene or an argument of this name is NULL. */
ctStatus ctFailMissing(ctChainTree* scene, const char* argument);

/* Ends a public call that lacks its scene or an argument. */
#define CT_REQUIRE(scene, argument)              \
  do {                                           \
    if ((scene) == NULL || (argument) == NULL) { \
      return ctFailMissing(scene, #argument);    \
    }                                            \
  } while (0)

/* Sets the box, NULL for none, and leaves the state alone, which depends on it. Writes what is wrong with the box, if
 * anything, and returns false. */
bool ctSceneTakeBox(ctChainTree* scene, const double (*vectors)[3], char* text, size_t size);

/* Fails unless a cutoff is finite and positive and, in a periodic box, at most half its width. */
ctStatus ctCheckCutoff(ctChainTree* scene, double cutoff);

/* Fails unless all of these are particles of the scene. */
ctStatus ctCheckParticles(ctChainTree* scene, int count, const int* particles);

/* The tree of the state, with tight bounds. Refreshes what is outdated. */
Tree* ctSceneTree(ctChainTree* scene);

/* Where the nodes of that tree are. */
World* ctSceneWorld(ctChainTree* scene);

/* The same as ctSceneTree, but bounds may be loose, see tree.h. For trials of few slots. */
Tree* ctSceneLooseTree(ctChainTree* scene);

/* Most that a pair is beyond its limit, nm; 0: none is. INFINITY: more than `most`, or there is no memory, which is no
 * failure and leaves the error text alone. */
double ctSceneExcess(ctChainTree* scene, double most, ctCounts* counts);

/* Makes the open trial the state until ctSceneLeaveTrial restores the former one, bit by bit. Returns its last
 * argument. */
bool ctSceneEnterTrial(ctChainTree* scene);
void ctSceneLeaveTrial(ctChainTree* scene, bool areLeavesKept);

/* The image of slot A that is nearest to slot B, see ctNearestImage. */
Image ctSceneNearestImage(ctChainTree* scene, int slotA, int slotB);

/* Searches the state's images, if it is periodic, for pairs whose surfaces are within reach of each other. */
void ctSceneSearchImages(ctChainTree* scene, double reach, CandidateFunction* function, void* context,
                         ctCounts* counts);

/* A sweep over the state, with a snapshot of it; NULL if there is no memory. */
Sweep* ctSceneSweep(ctChainTree* scene);

static inline bool canBond(unsigned donor, unsigned acceptor) {
  return (donor & ctDonor) != 0 && (acceptor & ctAcceptor) != 0;
}

static inline double pairTolerance(const ctChainTree* scene, int slotA, int slotB) {
  const Sequence* s = &scene->sequence;
  const unsigned a = s->types[s->slotType[slotA]].role;
  const unsigned b = s->types[s->slotType[slotB]].role;
  const bool bond = canBond(a, b) || canBond(b, a);
  return scene->overlapTolerance + (bond ? scene->hydrogenBondAllowance : 0);
}

static inline double radiusSum(const ctChainTree* scene, int slotA, int slotB) {
  return slotRadius(&scene->sequence, slotA) + slotRadius(&scene->sequence, slotB);
}

/* The particles of two slots, lower first. */
static inline void particlesOf(const ctChainTree* scene, int slotA, int slotB, int pair[2]) {
  const int a = scene->sequence.slotParticle[slotA];
  const int b = scene->sequence.slotParticle[slotB];
  pair[0] = a < b ? a : b;
  pair[1] = a < b ? b : a;
}

/* The canonical distance, in the image that is looked at. */
static inline double canonicalDistance(ctChainTree* scene, int slotA, int slotB) {
  const Tree* tree = ctSceneTree(scene);
  const Image* image = scene->traversal.image;
  return sqrt(image != NULL ? ctTreeSquaredImageDistance(tree, slotA, slotB, image)
                            : ctTreeSquaredDistance(tree, slotA, slotB));
}

#endif /* CT_SCENE_H_ */
