/* Pairs within a cutoff, counted on a lattice, whatever its links are. */
#include "lattice.h"

/* How many pairs have which distance. */
typedef struct Shells {
  int counts[5]; /* by squared distance */
  int others;
} Shells;

static bool countShell(void* context, int particle1, int particle2, double distance) {
  Shells* shells = context;
  int a[3];
  int b[3];
  latticeSite(particle1, a);
  latticeSite(particle2, b);
  const int squared = (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
  const bool isRight = particle1 < particle2 && fabs(distance - sqrt(squared)) < 1e-13;
  if (isRight && squared < 5) {
    shells->counts[squared]++;
  } else {
    shells->others++;
  }
  return true;
}

static void testShells(LatticeLinks links) {
  /* a cutoff is "at most": pairs that far apart to the last bit count */
  const double cutoffs[] = {0.999, 1, 1.001, 1.4, 1.42, 1.74, 2};
  const int reached[] = {0, 1, 1, 1, 2, 3, 4};
  ctChainTree* tree = makeLattice(links, 0.1, 0);
  for (int n = 0; n < 7; n++) {
    Shells shells = {{0}, 0};
    CHECK_SUCCESS(ctForEachNeighborPair(tree, cutoffs[n], countShell, &shells, NULL));
    for (int squared = 1; squared < 5; squared++) {
      CHECK(shells.counts[squared] == (squared <= reached[n] ? latticePairs(squared) : 0));
    }
    CHECK(shells.others == 0);
  }
  PairCount all = {0};
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 100, countPair, &all, NULL));
  CHECK(all.count == SITES * (SITES - 1) / 2);
  CHECK_FAILURE(tree, ctInvalidArgument, "cutoff is 0", ctForEachNeighborPair(tree, 0, countPair, &all, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "cutoff is -1", ctForEachNeighborPair(tree, -1, countPair, &all, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "nan", ctForEachNeighborPair(tree, NAN, countPair, &all, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "inf", ctForEachNeighborPair(tree, INFINITY, countPair, &all, NULL));
  ctDestroy(tree);
}

/* Spheres that touch don't clash; a little larger, they do. */
static void testContacts(LatticeLinks links) {
  PairCount clashes = {0};
  ctChainTree* tree = makeLattice(links, 0.5, 0);
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &clashes, NULL));
  CHECK(clashes.count == 0);
  ctDestroy(tree);
  tree = makeLattice(links, 0.51, 0.0199);
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &clashes, NULL));
  CHECK(clashes.count == latticePairs(1));
  CHECK_NEAR(clashes.value, 0.02, 1e-14);
  double energy;
  CHECK_SUCCESS(ctComputeEnergy(tree, 2, &energy, NULL, NULL));
  CHECK_NEAR(energy, latticePairs(1) * 1e-8, 1e-15);
  ctDestroy(tree);
}

int main(void) {
  for (int links = 0; links < latticeLinkings; links++) {
    testShells(links);
    testContacts(links);
  }
  return checkResult();
}
