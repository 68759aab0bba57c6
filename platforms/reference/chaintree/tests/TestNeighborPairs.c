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

enum { MOST = SITES * (SITES - 1) / 2 };

typedef struct Arrays {
  int particles[2][MOST + 1];
  double distances[MOST + 1];
} Arrays;

/* Arrays of any capacity: what fits is there, nothing is written beyond, and the count is that of all. */
static void testCapacities(ctChainTree* tree, double cutoff, const Arrays* all, size_t total) {
  static Arrays some;
  const size_t capacities[] = {0, 1, 255, 256, 257, 1024, 1500, total - 1, total};
  for (int c = 0; c < 9; c++) {
    const size_t capacity = capacities[c];
    const size_t kept = capacity < total ? capacity : total;
    size_t count = 0;
    memset(&some, 0xee, sizeof some);
    const int untouched = some.particles[0][MOST];
    const double untouchedDistance = some.distances[MOST];
    CHECK_SUCCESS(ctGetNeighborPairs(tree, cutoff, false, capacity, some.particles[0], some.particles[1],
                                     some.distances, &count, NULL));
    CHECK(count == total);
    for (int k = 0; k < 2; k++) {
      CHECK(some.particles[k][capacity] == untouched);
      CHECK(memcmp(some.particles[k], all->particles[k], kept * sizeof(int)) == 0);
    }
    CHECK(memcmp(&some.distances[capacity], &untouchedDistance, sizeof(double)) == 0);
    for (size_t i = 0; i < kept; i++) {
      CHECK(some.distances[i] <= cutoff && some.distances[i] > 0.999);
    }
  }
}

static void testArrays(LatticeLinks links) {
  static Arrays all;
  static int rows[MOST][2];
  const double cutoffs[] = {1, 1.5, 100};
  ctChainTree* tree = makeLattice(links, 0.1, 0);
  for (int n = 0; n < 3; n++) {
    Shells shells = {{0}, 0};
    size_t total = 0;
    CHECK_SUCCESS(
        ctGetNeighborPairs(tree, cutoffs[n], false, MOST, all.particles[0], all.particles[1], NULL, &total, NULL));
    for (size_t i = 0; i < total; i++) {
      double squared = 0;
      for (int k = 0; k < 2; k++) {
        rows[i][k] = all.particles[k][i];
      }
      for (int k = 0; k < 3; k++) {
        int a[3];
        int b[3];
        latticeSite(rows[i][0], a);
        latticeSite(rows[i][1], b);
        squared += (a[k] - b[k]) * (a[k] - b[k]);
      }
      CHECK(sqrt(squared) <= cutoffs[n]);
      countShell(&shells, rows[i][0], rows[i][1], sqrt(squared));
    }
    for (int squared = 1; squared < 5; squared++) {
      CHECK(shells.counts[squared] == (squared <= cutoffs[n] * cutoffs[n] ? latticePairs(squared) : 0));
    }
    qsort(rows, total, sizeof *rows, compareRows);
    for (size_t i = 1; i < total; i++) {
      CHECK(compareRows(rows[i - 1], rows[i]) < 0);
    }
    testCapacities(tree, cutoffs[n], &all, total);
    CHECK_SUCCESS(ctGetNeighborPairs(tree, cutoffs[n], true, total, all.particles[0], all.particles[1], all.distances,
                                     &total, NULL));
    for (size_t i = 0; i < total; i++) {
      const int row[] = {all.particles[0][i], all.particles[1][i]};
      CHECK(compareRows(row, rows[i]) == 0);
    }
  }
  size_t count;
  CHECK_FAILURE(tree, ctInvalidArgument, "cutoff is 0",
                ctGetNeighborPairs(tree, 0, true, MOST, all.particles[0], all.particles[1], NULL, &count, NULL));
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
