/* Every allocation of every call fails once: the call says so, changes nothing, and works the next time.
 *
 * The program puts its own functions before the C library's allocator; where that cannot be done, it is skipped. */
#define _XOPEN_SOURCE 700 /* putenv */

#include "lattice.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define SANITIZED
#endif

#ifdef SANITIZED

int main(void) {
  return 77;
}

#else

extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* old, size_t size);
extern void* __libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void* memory);

static int allocationsLeft = -1; /* until one fails; negative: none does */
static bool hasFailed = false;   /* one has */
static int live = 0;             /* blocks that nobody has freed */

static bool mayAllocate(void) {
  if (allocationsLeft == 0) {
    allocationsLeft = -1;
    hasFailed = true;
    return false;
  }
  allocationsLeft -= allocationsLeft > 0;
  return true;
}

static void failAllocation(int number) {
  hasFailed = false;
  allocationsLeft = number;
}

static void* counted(void* memory) {
  live += memory != NULL;
  return memory;
}

void* malloc(size_t size) {
  return mayAllocate() ? counted(__libc_malloc(size)) : NULL;
}

void* calloc(size_t count, size_t size) {
  return mayAllocate() ? counted(__libc_calloc(count, size)) : NULL;
}

void* aligned_alloc(size_t alignment, size_t size) {
  return mayAllocate() ? counted(__libc_memalign(alignment, size)) : NULL;
}

void* realloc(void* old, size_t size) {
  if (!mayAllocate()) {
    return NULL;
  }
  void* memory = __libc_realloc(old, size);
  live += old == NULL && memory != NULL;
  return memory;
}

void free(void* memory) {
  live -= memory != NULL;
  __libc_free(memory);
}

/* ---- Creation ---- */

static void testCreate(void) {
  const double positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 1, 0};
  const double radii[] = {0.1, 0.1, 0.1, 0.1};
  const int particleLinks[] = {0, 0, 1, 1};
  const int parents[] = {CT_NULL, 0};
  const uint8_t joints[] = {ctFreeJoint, ctTorsionJoint};
  const int torsions[][4] = {{0}, {0, 1, 2, 3}};
  const int exclusions[][2] = {{0, 1}};
  const ctDefinition definition = {.particleCount = 4,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = 2,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions,
                                   .exclusionCount = 1,
                                   .exclusions = exclusions};
  const int before = live;
  int n = 0;
  do {
    ctChainTree* tree = NULL;
    char text[100] = "";
    failAllocation(n++);
    const ctStatus status = ctCreate(&definition, &tree, text, sizeof text);
    allocationsLeft = -1;
    if (status != ctSuccess) {
      CHECK(hasFailed && status == ctOutOfMemory && tree == NULL && strcmp(text, "out of memory") == 0);
      CHECK(live == before);
    }
    ctDestroy(tree);
    CHECK(live == before);
  } while (hasFailed);
  CHECK(n > 10);
}

/* ---- Calls ---- */

/* Beads that just touch, so that a verdict has many pairs to decide by their canonical distance. */
static ctChainTree* makeTouching(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.5, 0);
  const ctChange change = {.link = 4, .translation = {0, 0, 0}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  return tree;
}

static ctStatus proposeMany(ctChainTree* tree) {
  ctChange changes[SIDE] = {{0}};
  for (int link = 0; link < SIDE; link++) {
    changes[link].link = link;
    changes[link].translation[0] = 0.1;
  }
  return ctPropose(tree, SIDE, changes);
}

static ctStatus test(ctChainTree* tree) {
  bool clash;
  return ctTestTrial(tree, &clash, NULL, NULL);
}

static bool passChangedPair(void* context, int particle1, int particle2, double before, double after) {
  return countPair(context, particle1, particle2, fmin(before, after));
}

static ctStatus listChanged(ctChainTree* tree) {
  PairCount pairs = {0};
  return ctForEachChangedPair(tree, 1.2, passChangedPair, &pairs, NULL);
}

static ctStatus commit(ctChainTree* tree) {
  return ctCommit(tree, NULL);
}

static ctStatus setLimits(ctChainTree* tree) {
  const int pairs[][2] = {{4, 3}, {1, 2}};
  const double limits[] = {0.1, 0.2};
  return ctSetLimits(tree, 2, pairs, limits);
}

static ctStatus raiseLimits(ctChainTree* tree) {
  int raised;
  return ctRaiseLimits(tree, &raised, NULL);
}

static ctStatus selectFew(ctChainTree* tree) {
  const int particles[] = {0, 1};
  ctSelection* selection;
  const ctStatus status = ctSelect(tree, 2, particles, &selection);
  CHECK((selection != NULL) == (status == ctSuccess));
  ctFreeSelection(selection);
  return status;
}

static ctStatus hasClash(ctChainTree* tree) {
  bool clash;
  return ctHasClash(tree, &clash, NULL, NULL);
}

static ctStatus computeEnergy(ctChainTree* tree) {
  double energy;
  return ctComputeEnergy(tree, 1, &energy, NULL, NULL);
}

/* A validation that is refused memory is none. */
static ctStatus validate(ctChainTree* tree) {
  const bool valid = ctValidate(tree);
  CHECK(valid != hasFailed);
  return ctSuccess;
}

static ctStatus listNeighbors(ctChainTree* tree) {
  PairCount pairs = {0};
  return ctForEachNeighborPair(tree, 1.2, countPair, &pairs, NULL);
}

static ctStatus sortNeighbors(ctChainTree* tree) {
  static int particles[2][SITES * SITES];
  size_t count;
  return ctGetNeighborPairs(tree, 1.2, true, SITES * SITES, particles[0], particles[1], NULL, &count, NULL);
}

static ctStatus setSamePositions(ctChainTree* tree) {
  static double positions[3 * SITES];
  ctGetPositions(tree, positions);
  return ctSetPositions(tree, positions);
}

/* `allocates`: whether the call needs memory at all, on a scene that has not been used before. */
static void testCall(const char* name, ctStatus (*call)(ctChainTree* tree), bool allocates, double overlap) {
  static double state[3 * SITES];
  static double trial[3 * SITES];
  static double now[3 * SITES];
  int refused = 0;
  int n = 0;
  do {
    ctChainTree* tree = makeTouching();
    const int pair[][2] = {{0, 1}};
    const double limit = 0.3;
    if (overlap > 0) {
      const ctChange change = {.link = 0, .translation = {0, 0, overlap}};
      CHECK_SUCCESS(ctPropose(tree, 1, &change));
      CHECK_SUCCESS(ctCommit(tree, NULL));
    }
    CHECK_SUCCESS(ctSetLimits(tree, 1, pair, &limit));
    ctGetPositions(tree, state);
    const bool hasTrial = ctHasTrial(tree);
    if (hasTrial) {
      CHECK_SUCCESS(ctGetTrialPositions(tree, trial));
    }
    failAllocation(n++);
    const ctStatus status = call(tree);
    allocationsLeft = -1;
    CHECK(status == ctSuccess || (hasFailed && status == ctOutOfMemory));
    if (status != ctSuccess) {
      refused++;
      CHECK(strcmp(ctGetErrorText(tree), "out of memory") == 0);
      CHECK(ctHasTrial(tree) == hasTrial);
      CHECK(ctGetLimitCount(tree) == 1);
      ctGetPositions(tree, now);
      CHECK(memcmp(state, now, sizeof state) == 0);
      if (hasTrial) {
        CHECK_SUCCESS(ctGetTrialPositions(tree, now));
        CHECK(memcmp(trial, now, sizeof trial) == 0);
      }
      CHECK(call(tree) == ctSuccess);
      CHECK(ctValidate(tree));
    }
    ctDestroy(tree);
  } while (hasFailed);
  if ((refused > 0) != allocates) {
    printf("%s was refused memory %d times\n", name, refused);
    checkFailures++;
  }
}

/* A selection of particles that are not modelled needs more. */
static void testSelectBare(void) {
  static const int particles[] = {7, 300, 7};
  ctChainTree* tree = makeLattice(LAYERS, 0, 0);
  ctSelection* selection;
  ctStatus status;
  int n = 0;
  do {
    failAllocation(n++);
    status = ctSelect(tree, 3, particles, &selection);
    allocationsLeft = -1;
    CHECK(status == (hasFailed ? ctOutOfMemory : ctSuccess) && (selection == NULL) == hasFailed);
    ctFreeSelection(selection);
  } while (hasFailed);
  CHECK(n > 5);
  ctDestroy(tree);
}

int main(void) {
  static char byCost[] = "CHAINTREE_TRIALS=cost";
  static char byClearances[] = "CHAINTREE_TRIALS=clearances";
  printf("\n"); /* its buffer is no leak of ours, nor is the environment */
  putenv(byCost);
  const int before = live;
  testCreate();
  testCall("propose", proposeMany, true, 0);
  testCall("test", test, true, 0);
  putenv(byClearances);
  testCall("test by clearances", test, true, 0);
  putenv(byCost);
  testCall("list changed pairs", listChanged, true, 0);
  testCall("set limits", setLimits, true, 0);
  testCall("raise limits", raiseLimits, true, 0.2);
  testCall("select", selectFew, true, 0);
  testSelectBare();
  testCall("has clash", hasClash, true, 0.2);
  testCall("compute energy", computeEnergy, true, 0.2);
  testCall("validate", validate, false, 0);
  testCall("commit", commit, false, 0);
  testCall("list neighbours", listNeighbors, true, 0);
  testCall("sort neighbours", sortNeighbors, true, 0.2);
  testCall("set positions", setSamePositions, false, 0);
  CHECK(live == before);
  return checkResult();
}

#endif
