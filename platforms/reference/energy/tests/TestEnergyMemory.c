/* Every allocation of every call on an energy fails once: the call says so, and the energy is as good as new once the
 * caller has done what the header asks for. By every instruction set, without Born solvation and with it.
 *
 * The program puts its own functions before the C library's allocator; where that cannot be done, it is skipped. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../../chaintree/tests/failingallocator.h"

#ifndef HAS_GLIBC_ALLOCATOR

int main(void) {
  return 77;
}

#else

#include "beadenergy.h"

/* What comes out where nothing fails. */
typedef struct Expected {
  double start;
  double change;
  double end;
} Expected;

static Expected findExpected(void) {
  Expected expected;
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  expected.start = total(&bench);
  propose(&bench);
  CHECK(computeChange(&bench, &expected.change) == ctSuccess);
  CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
  expected.end = total(&bench);
  CHECK(fabs(expected.end - expected.start - expected.change) < 1e-9);
  CHECK(fabs(expected.change) > 1);
  destroyBench(&bench);
  return expected;
}

static void checkRefusal(const Bench* bench, ctStatus status) {
  CHECK(hasFailed && status == ctOutOfMemory);
  CHECK(strcmp(ctGetEnergyErrorText(bench->energy), "out of memory") == 0);
}

/* ---- Calls: sorting does without memory if it has to, so that not each allocation that fails is noticed ---- */

static void testCreate(void) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    ctChainTree* tree;
    ctEnergy* energy = NULL;
    char text[100] = "";
    CHECK(ctCreate(&scene, &tree, NULL, 0) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctCreateEnergy(tree, described, &energy, text, sizeof text);
    allocationsLeft = -1;
    goesOn = hasFailed;
    CHECK((status == ctSuccess) == (energy != NULL));
    if (status != ctSuccess) {
      refused++;
      CHECK(hasFailed && status == ctOutOfMemory && strcmp(text, "out of memory") == 0);
      /* The scene is none the worse for it. */
      CHECK(ctCreateEnergy(tree, described, &energy, text, sizeof text) == ctSuccess);
      CHECK(ctRefreshEnergy(energy, NULL) == ctSuccess);
    }
    ctDestroyEnergy(energy);
    ctDestroy(tree);
    CHECK(live == before);
  }
  CHECK(refused > 20);
}

static void testRefresh(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    Bench bench = makeBench();
    failAllocation(n);
    const ctStatus status = ctRefreshEnergy(bench.energy, NULL);
    allocationsLeft = -1;
    goesOn = hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    }
    CHECK(total(&bench) == expected->start);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 5);
}

/* A change that was refused memory can be asked for again, in the same trial or in another. */
static void testChange(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    double change;
    Bench bench = makeBench();
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    propose(&bench);
    failAllocation(n);
    const ctStatus status = computeChange(&bench, &change);
    allocationsLeft = -1;
    goesOn = hasFailed;
    CHECK(total(&bench) == expected->start);
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      if (n % 2 == 0) {
        ctReject(bench.tree);
        propose(&bench);
      }
      CHECK(computeChange(&bench, &change) == ctSuccess);
    }
    CHECK(change == expected->change);
    CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
    CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
    CHECK(total(&bench) == expected->end);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 3);
}

/* A change that was refused memory when the trial was accepted does not belong to the state, which has to be refreshed.
 */
static void testAccept(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    double change;
    Bench bench = makeBench();
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    propose(&bench);
    CHECK(computeChange(&bench, &change) == ctSuccess);
    CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctAcceptEnergyChange(bench.energy);
    allocationsLeft = -1;
    goesOn = hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    }
    CHECK(status == ctSuccess ? total(&bench) == expected->end
                              : fabs(total(&bench) - expected->end) < 1e-6 * fabs(expected->end));
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 0);
}

/* A copy that was refused memory is none; one that was made before needs none. */
static void testKeep(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    Bench bench = makeBench();
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctSaveEnergy(bench.energy);
    allocationsLeft = -1;
    goesOn = hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctRestoreEnergy(bench.energy) == ctInvalidArgument);
      CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
    }
    failAllocation(0);
    CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
    CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
    allocationsLeft = -1;
    CHECK(total(&bench) == expected->start);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 3);
}

/* ---- With Born solvation alone ---- */

/* Constants that could not be renewed are as they were, whether the energy was of the state before or not. */
static void testRenew(bool isRefreshed) {
  static double constants[BEADS];
  static double renewed[BEADS];
  Bench sound = makeBench();
  CHECK(ctRenewStandIn(sound.energy, NULL) == ctSuccess);
  ctGetStandIn(sound.energy, renewed);
  const double expected = total(&sound);
  destroyBench(&sound);
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    Bench bench = makeBench();
    CHECK(!isRefreshed || ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctRenewStandIn(bench.energy, NULL);
    allocationsLeft = -1;
    goesOn = hasFailed;
    ctGetStandIn(bench.energy, constants);
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      for (int i = 0; i < BEADS; i++) {
        CHECK(constants[i] == 0);
      }
      CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
      ctGetStandIn(bench.energy, constants);
    }
    CHECK(memcmp(constants, renewed, sizeof renewed) == 0);
    CHECK(ctIsEnergyOfState(bench.energy) && total(&bench) == expected);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > (isRefreshed ? 1 : 20));
}

static void testWhole(void) {
  double expected[2];
  int refused = 0;
  bool goesOn = true;
  for (int n = -1; goesOn; n++) {
    double found[2];
    Bench bench = makeBench();
    hasFailed = false;
    allocationsLeft = n;
    const ctStatus status = ctComputeWholeEnergy(bench.energy, &found[0], &found[1], NULL);
    allocationsLeft = -1;
    goesOn = n < 0 || hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctComputeWholeEnergy(bench.energy, &found[0], &found[1], NULL) == ctSuccess);
    }
    if (n < 0) {
      memcpy(expected, found, sizeof found);
    }
    CHECK(memcmp(expected, found, sizeof found) == 0);
    destroyBench(&bench);
  }
  CHECK(refused > 0);
}

/* Many trials that are dropped, one after another, need no more memory than the first of them, whether they were asked
 * about all of their change or about near pairs alone. */
static void testManyDropped(void) {
  Bench bench = makeBench();
  double change;
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  for (int n = 0; n < 100; n++) {
    propose(&bench);
    const int before = asked;
    CHECK(ctComputeEnergyChange(bench.energy, ctTermsPart, &change, NULL) == ctSuccess);
    CHECK(ctComputeEnergyChange(bench.energy, ctNearPairsPart, &change, NULL) == ctSuccess);
    CHECK(n % 2 == 1 || ctComputeEnergyChange(bench.energy, ctOtherPairsPart, &change, NULL) == ctSuccess);
    CHECK(n < 2 || asked == before);
    ctReject(bench.tree);
  }
  destroyBench(&bench);
}

/* Trials that are dropped, and blocks of trials that are taken back, need no more memory than the first of them. */
static void testDropped(void) {
  int before = 0;
  Bench bench = makeBench();
  double change;
  double* state = malloc(ctGetStateSize(bench.tree) * sizeof *state);
  ctGetState(bench.tree, state);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  for (int n = 0; n < 200; n++) {
    propose(&bench);
    before = asked;
    CHECK(computeChange(&bench, &change) == ctSuccess);
    ctReject(bench.tree);
    CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
    CHECK(n < 2 || asked == before);
    propose(&bench);
    before = asked;
    CHECK(computeChange(&bench, &change) == ctSuccess);
    CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
    CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
    CHECK(ctSetState(bench.tree, state) == ctSuccess);
    CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
    CHECK(n < 2 || asked == before);
  }
  free(state);
  destroyBench(&bench);
}

/* Trials that fold and unfold need no more memory than the first of them. */
static void testAccepted(void) {
  Bench bench = makeBench();
  double change;
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  for (int n = 0; n < 100; n++) {
    proposeTimes(&bench, n % 2 == 0 ? 1 : -1);
    int before = asked;
    CHECK(computeChange(&bench, &change) == ctSuccess);
    CHECK(n < 10 || asked == before);
    CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
    before = asked;
    CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
    CHECK(n < 10 || asked == before);
  }
  destroyBench(&bench);
}

static void testAll(void) {
  const Expected expected = findExpected();
  testCreate();
  testRefresh(&expected);
  testChange(&expected);
  testAccept(&expected);
  testKeep(&expected);
  testManyDropped();
  testDropped();
  testAccepted();
}

int main(void) {
  printf("\n"); /* its buffer is no leak of ours */
  describe();
  const char* const sets[] = {"avx512", "avx2", "portable"};
  for (int i = 0; i < 3; i++) {
    setenv("CHAINTREE_SIMD", sets[i], 1);
    described = &definition;
    testAll();
    described = &definitionWithBorn;
    testAll();
    testRenew(false);
    testRenew(true);
    testWhole();
  }
  return checkResult();
}

#endif
