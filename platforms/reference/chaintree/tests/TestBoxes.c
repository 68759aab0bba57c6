/* Rods and sheets, whose boxes are thin or flat, in any direction: neighbour pairs against all pairs. */
#include "beads.h"

static void checkPairs(Beads* beads, const double direction[3], const double across[3], int rows, double cutoff) {
  int expected = 0;
  for (int i = 0; i < beads->count; i++) {
    beads->radii[i] = 0.01;
    for (int k = 0; k < 3; k++) {
      beads->positions[3 * i + k] = i / rows * direction[k] + i % rows * across[k];
    }
    for (int j = 0; j < i; j++) {
      double squared = 0;
      for (int k = 0; k < 3; k++) {
        const double d = beads->positions[3 * i + k] - beads->positions[3 * j + k];
        squared += d * d;
      }
      expected += squared <= cutoff * cutoff;
    }
  }
  ctChainTree* tree = makeBeads(beads);
  PairCount pairs = {0};
  CHECK_SUCCESS(ctForEachNeighborPair(tree, cutoff, countPair, &pairs, NULL));
  CHECK(pairs.count == expected);
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

int main(void) {
  const double directions[][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {1, 2, 3}, {-0.3, 0.7, 0.1}, {0.001, 1, 0}};
  const double across[][3] = {{0, 0, 0}, {0, 0.5, 0}, {0.3, 0.3, -0.3}, {1e-5, 0, 0}};
  for (int count = 1; count <= MOST_BEADS; count++) {
    for (int d = 0; d < 6; d++) {
      for (int a = 0; a < 4; a++) {
        for (int rows = 1; rows <= 3; rows++) {
          Beads beads = {.count = count};
          /* Not at a distance that occurs. */
          checkPairs(&beads, directions[d], across[a], rows, 2.718281828);
        }
      }
    }
  }
  return checkResult();
}
