/* Pairs within a cutoff where all leaves come near all others, more than a sweep takes at a time: a chain that visits
 * the sites of a lattice as if at random. */
#include "chain.h"

/* Site i of the lattice, row by row, is that of particle i * STRIDE modulo BEADS, which STRIDE has no divisor of. */
enum { ROW = 26, BEADS = ROW * ROW * ROW, STRIDE = 17001, NEIGHBORS = 3 * ROW * ROW * (ROW - 1) };

static const int EXCLUDED[1][2] = {{0, STRIDE}};

static ctChainTree* makeBeads(void) {
  Chain chain = allocateChain(BEADS, BEADS, ctFreeJoint);
  chain.exclusionCount = 1;
  chain.exclusions = EXCLUDED;
  for (int site = 0; site < BEADS; site++) {
    const int i = site * STRIDE % BEADS;
    const double position[3] = {site % ROW, site / ROW % ROW, site / ROW / ROW};
    setBead(&chain, i, position, 0.1);
  }
  return createChain(&chain);
}

int main(void) {
  static int lower[NEIGHBORS];
  static int higher[NEIGHBORS];
  static double distances[NEIGHBORS];
  ctChainTree* beads = makeBeads();
  for (int sorted = 0; sorted < 2; sorted++) {
    size_t count = 0;
    CHECK_SUCCESS(ctGetNeighborPairs(beads, 1, sorted == 1, NEIGHBORS, lower, higher, distances, &count, NULL));
    CHECK(count == NEIGHBORS - 1);
    for (size_t i = 0; i < count; i++) {
      CHECK(lower[i] < higher[i] && fabs(distances[i] - 1) < 1e-12);
      CHECK(lower[i] != EXCLUDED[0][0] || higher[i] != EXCLUDED[0][1]);
      CHECK(sorted == 0 || i == 0 || lower[i] > lower[i - 1] ||
            (lower[i] == lower[i - 1] && higher[i] > higher[i - 1]));
    }
  }
  ctDestroy(beads);
  return checkResult();
}
