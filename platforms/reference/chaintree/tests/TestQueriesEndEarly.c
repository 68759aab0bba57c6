/* A callback that returns false ends its query: no error, no further call, nothing changed. */
#include "lattice.h"

typedef struct Countdown {
  int calls;
  int last; /* the call that returns false */
} Countdown;

static bool countDown(void* context) {
  Countdown* countdown = context;
  return ++countdown->calls != countdown->last;
}

static bool onPair(void* context, int particle1, int particle2, double value) {
  CHECK(particle1 >= 0 && particle1 < particle2 && particle2 < SITES && value > 0);
  return countDown(context);
}

static bool onChangedPair(void* context, int particle1, int particle2, double before, double after) {
  return onPair(context, particle1, particle2, fmin(before, after));
}

static bool onParticle(void* context, int particle, double overlap) {
  return onPair(context, particle - 1 < 0 ? 0 : particle - 1, particle < 1 ? 1 : particle, overlap);
}

int main(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.6, 0.1);
  static double before[3 * SITES];
  static double after[3 * SITES];
  ctGetPositions(tree, before);
  const double middle[] = {4, 4, 4};
  const ctChange change = {.link = 3, .rotation = {0, 0, 0.1}, .pivot = {4, 4, 0}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  for (int last = 1; last < 30; last += 7) {
    Countdown countdown = {0, last};
    CHECK_SUCCESS(ctForEachClash(tree, onPair, &countdown, NULL));
    CHECK(countdown.calls == last);
    countdown.calls = 0;
    CHECK_SUCCESS(ctForEachNeighborPair(tree, 1.5, onPair, &countdown, NULL));
    CHECK(countdown.calls == last);
    countdown.calls = 0;
    CHECK_SUCCESS(ctForEachChangedPair(tree, 1.5, onChangedPair, &countdown, NULL));
    CHECK(countdown.calls == last);
    countdown.calls = 0;
    CHECK_SUCCESS(ctForEachClashWith(tree, middle, 3, onParticle, &countdown, NULL));
    CHECK(countdown.calls == last);
    CHECK(ctHasTrial(tree));
    ctGetPositions(tree, after);
    CHECK(memcmp(before, after, sizeof before) == 0);
  }
  CHECK(ctValidate(tree));
  ctDestroy(tree);
  return checkResult();
}
