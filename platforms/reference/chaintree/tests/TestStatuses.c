/* Calls that fail: what they return, what they say, and that they change nothing. */
#include "arm.h"

enum { LINKS = 20, COORDINATES = 6 * LINKS };

static bool refuseChangedPair(void* context, int particle1, int particle2, double before, double after) {
  (void)context;
  (void)particle1;
  (void)particle2;
  (void)before;
  (void)after;
  CHECK(!"called");
  return true;
}

static void testWithoutTrial(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double positions[COORDINATES];
  bool clash;
  CHECK(ctGetErrorText(arm)[0] == '\0');
  for (int n = 0; n < 3; n++) {
    CHECK(!ctHasTrial(arm));
    CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctTestTrial(arm, &clash, NULL, NULL));
    CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctGetTrialPositions(arm, positions));
    CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctFollowTrialPositions(arm, true, positions));
    CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctForEachChangedPair(arm, 1, refuseChangedPair, NULL, NULL));
    CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctAccept(arm, NULL));
    /* after an accepted trial, after a rejected one */
    CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 3, .angle = 0.1}));
    if (n == 0) {
      CHECK_SUCCESS(ctAccept(arm, NULL));
    } else {
      ctReject(arm);
    }
  }
  ctDestroy(arm);
}

static void testNothingChanges(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  turnArm(arm, 5, 0.4);
  const int pair[][2] = {{0, 5}};
  const double limit = 0.1;
  CHECK_SUCCESS(ctSetLimits(arm, 1, pair, &limit));
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 9, .angle = 0.1}));
  double state[COORDINATES];
  double trial[COORDINATES];
  double now[COORDINATES];
  ctGetPositions(arm, state);
  CHECK_SUCCESS(ctGetTrialPositions(arm, trial));

  memcpy(now, trial, sizeof now);
  now[7] = NAN;
  CHECK_FAILURE(arm, ctInvalidArgument, "particle 2", ctSetPositions(arm, now));
  const int none[][2] = {{0, 2 * LINKS}};
  CHECK_FAILURE(arm, ctInvalidArgument, "limit 0", ctSetLimits(arm, 1, none, &limit));
  const ctChange infinite = {.link = 0, .translation = {0, 0, INFINITY}};
  CHECK_FAILURE(arm, ctInvalidArgument, "link 0", ctPropose(arm, 1, &infinite));
  double centroid[3];
  ctTransform transform;
  CHECK_FAILURE(arm, ctInvalidArgument, "link 20", ctGetCentroid(arm, LINKS, centroid));
  CHECK_FAILURE(arm, ctInvalidArgument, "link -1", ctGetRelativeTransform(arm, -1, 0, &transform));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 20", ctGetRelativeTransform(arm, 0, LINKS, &transform));

  CHECK(ctHasTrial(arm));
  CHECK(ctGetLimitCount(arm) == 1);
  ctGetPositions(arm, now);
  CHECK(memcmp(now, state, sizeof now) == 0);
  CHECK_SUCCESS(ctGetTrialPositions(arm, now));
  CHECK(memcmp(now, trial, sizeof now) == 0);
  CHECK(strstr(ctGetErrorText(arm), "link 20") != NULL); /* the text outlives calls that succeed */
  CHECK(ctValidate(arm));
  ctDestroy(arm);
}

static const double nonFinite[] = {NAN, INFINITY, -INFINITY};

/* Each number of a call, one after another. */
static void testEachNumber(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  PairCount pairs = {0};
  double energy = -1;
  for (int bad = 0; bad < 3; bad++) {
    for (int i = 0; i < 9; i++) {
      ctChange change = {.link = 0};
      double* vectors[] = {change.rotation, change.pivot, change.translation};
      vectors[i / 3][i % 3] = nonFinite[bad];
      CHECK_FAILURE(arm, ctInvalidArgument, "link 0", ctPropose(arm, 1, &change));
      /* arrays that a torsion does not read */
      change.link = 1;
      CHECK_SUCCESS(ctPropose(arm, 1, &change));
    }
    CHECK_FAILURE(arm, ctInvalidArgument, "link 1", ctPropose(arm, 1, &(ctChange){.link = 1, .angle = nonFinite[bad]}));
    CHECK_FAILURE(arm, ctInvalidArgument, "cutoff",
                  ctForEachChangedPair(arm, nonFinite[bad], refuseChangedPair, NULL, NULL));
    CHECK_FAILURE(arm, ctInvalidArgument, "cutoff",
                  ctForEachNeighborPair(arm, nonFinite[bad], countPair, &pairs, NULL));
    CHECK_FAILURE(arm, ctInvalidArgument, "constant", ctComputeEnergy(arm, nonFinite[bad], &energy, NULL, NULL));
    for (int axis = 0; axis < 3; axis++) {
      double positions[COORDINATES];
      ctGetPositions(arm, positions);
      positions[3 * 17 + axis] = nonFinite[bad];
      CHECK_FAILURE(arm, ctInvalidArgument, "particle 17", ctSetPositions(arm, positions));
    }
  }
  CHECK_FAILURE(arm, ctInvalidArgument, "-1 changes", ctPropose(arm, -1, NULL));
  CHECK(pairs.count == 0 && energy == -1);
  ctDestroy(arm);
}

static void testEachPair(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  static const int nobody[][2] = {{-1, 0}, {0, -1}, {2 * LINKS, 0}, {0, 2 * LINKS}, {3, 3}};
  const double limit = 0.1;
  for (int i = 0; i < 5; i++) {
    CHECK_FAILURE(arm, ctInvalidArgument, "limit 0", ctSetLimits(arm, 1, &nobody[i], &limit));
    ctSelection* selection = (ctSelection*)arm; /* anything but NULL */
    if (i < 4) {
      CHECK_FAILURE(arm, ctInvalidArgument, "there is no particle", ctSelect(arm, 2, nobody[i], &selection));
      CHECK(selection == NULL);
    }
  }
  const int pairs[][2] = {{1, 2}, {2, 1}};
  const double limits[] = {0.1, NAN};
  CHECK_FAILURE(arm, ctInvalidArgument, "limit 1", ctSetLimits(arm, 2, pairs, limits));
  CHECK(ctGetLimitCount(arm) == 0);
  ctDestroy(arm);
}

/* No length is so large that bounds in single precision could not hold it, nor can it become so by many moves. */
static void testFarAway(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double before[COORDINATES];
  double after[COORDINATES];
  double state[COORDINATES + 7 + LINKS - 1];
  CHECK(ctGetStateSize(arm) == sizeof state / sizeof state[0]);
  ctGetPositions(arm, before);
  memcpy(after, before, sizeof after);
  after[7] = -1e39;
  CHECK_FAILURE(arm, ctInvalidArgument, "particle 2", ctSetPositions(arm, after));
  const double tooMuch = 1.1 * CT_MOST_LENGTH;
  const ctChange refused[] = {{.translation = {0, 0, -tooMuch}}, {.pivot = {tooMuch}}, {.rotation = {0, tooMuch}}};
  for (int n = 0; n < 3; n++) {
    CHECK_FAILURE(arm, ctInvalidArgument, "link 0", ctPropose(arm, 1, &refused[n]));
  }
  CHECK_FAILURE(arm, ctInvalidArgument, "probe", ctForEachClashWith(arm, refused[0].translation, 1, NULL, NULL, NULL));
  const double origin[3] = {0};
  CHECK_FAILURE(arm, ctInvalidArgument, "probe", ctForEachClashWith(arm, origin, tooMuch, NULL, NULL, NULL));

  const ctChange away = {.translation = {CT_MOST_LENGTH}};
  int moves = 0;
  while (moves < 20 && ctPropose(arm, 1, &away) == ctSuccess) {
    bool clash;
    CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
    CHECK_SUCCESS(ctAccept(arm, NULL));
    moves++;
  }
  CHECK(moves == 10 && strstr(ctGetErrorText(arm), "link 0") != NULL);
  ctGetPositions(arm, before);
  ctGetState(arm, state);
  CHECK_SUCCESS(ctSetState(arm, state));
  ctGetPositions(arm, after);
  CHECK(memcmp(before, after, sizeof before) == 0);
  state[COORDINATES + 5] *= 3;
  state[COORDINATES + 4] *= 3;
  CHECK_FAILURE(arm, ctInvalidArgument, "link 0", ctSetState(arm, state));
  ctDestroy(arm);
}

int main(void) {
  testWithoutTrial();
  testNothingChanges();
  testEachNumber();
  testEachPair();
  testFarAway();
  return checkResult();
}
