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

static int compareRows(const void* a, const void* b) {
  const int* x = a;
  const int* y = b;
  return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* Arrays of any capacity: what fits is there, nothing is written beyond, and the count is that of all. */
static void testArrays(LatticeLinks links) {
  enum { MOST = SITES * (SITES - 1) / 2 };
  static int all[MOST][2];
  static int some[MOST + 1][2];
  static double distances[MOST + 1];
  const double cutoffs[] = {1, 1.5, 100};
  ctChainTree* tree = makeLattice(links, 0.1, 0);
  for (int n = 0; n < 3; n++) {
    Shells shells = {{0}, 0};
    CHECK_SUCCESS(ctForEachNeighborPair(tree, cutoffs[n], countShell, &shells, NULL));
    size_t total = 0;
    CHECK_SUCCESS(ctGetNeighborPairs(tree, cutoffs[n], MOST, all, NULL, &total, NULL));
    for (size_t i = 0; i < total; i++) {
      double distance = 0;
      for (int k = 0; k < 3; k++) {
        int a[3];
        int b[3];
        latticeSite(all[i][0], a);
        latticeSite(all[i][1], b);
        distance += (a[k] - b[k]) * (a[k] - b[k]);
      }
      distance = sqrt(distance);
      CHECK(distance <= cutoffs[n]);
      shells.counts[0] += countShell(&shells, all[i][0], all[i][1], distance);
    }
    /* Every pair has come twice now. */
    CHECK(shells.counts[0] == (int)total);
    for (int squared = 1; squared < 5; squared++) {
      CHECK(shells.counts[squared] == (squared <= cutoffs[n] * cutoffs[n] ? 2 * latticePairs(squared) : 0));
    }
    const size_t capacities[] = {0, 1, 255, 256, 257, 1024, 1500, total - 1, total};
    for (int c = 0; c < 9; c++) {
      const size_t capacity = capacities[c];
      const size_t kept = capacity < total ? capacity : total;
      size_t count = 0;
      memset(some, 0xee, sizeof some);
      memset(distances, 0xee, sizeof distances);
      const int untouched = some[MOST][0];
      CHECK_SUCCESS(ctGetNeighborPairs(tree, cutoffs[n], capacity, some, distances, &count, NULL));
      CHECK(count == total);
      CHECK(some[capacity][0] == untouched && some[capacity][1] == untouched);
      CHECK(memcmp(&distances[capacity], some[capacity], sizeof(double)) == 0);
      CHECK(memcmp(some, all, kept * sizeof *some) == 0);
      for (size_t i = 0; i < kept; i++) {
        CHECK(distances[i] <= cutoffs[n] && distances[i] > 0.999);
      }
    }
    qsort(all, total, sizeof *all, compareRows);
    for (size_t i = 1; i < total; i++) {
      CHECK(compareRows(all[i - 1], all[i]) < 0);
    }
  }
  size_t count;
  CHECK_FAILURE(tree, ctInvalidArgument, "cutoff is 0", ctGetNeighborPairs(tree, 0, MOST, all, NULL, &count, NULL));
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
    testArrays(links);
    testContacts(links);
  }
  return checkResult();
}
