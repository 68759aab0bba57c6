/* Particles that overlap a sphere which is no particle. */
#include "lattice.h"

typedef struct Found {
  int count;
  int particle;
  double overlap;
} Found;

static bool note(void* context, int particle, double overlap) {
  Found* found = context;
  found->count++;
  found->particle = particle;
  found->overlap = overlap;
  return true;
}

static Found probe(ctChainTree* tree, double x, double y, double z, double radius) {
  const double position[] = {x, y, z};
  Found found = {0, CT_NULL, 0};
  ctCounts counts = {1, 1, 1};
  CHECK_SUCCESS(ctForEachClashWith(tree, position, radius, note, &found, &counts));
  CHECK(counts.volumeTests >= 1 && counts.particleTests >= 1);
  return found;
}

static void testLattice(LatticeLinks links) {
  ctChainTree* tree = makeLattice(links, 0.25, 0.05);
  Found found = probe(tree, 3.3, 2, 7, 0.25);
  CHECK(found.count == 1 && found.particle == siteIndex(3, 2, 7));
  CHECK_NEAR(found.overlap, 0.2, 1e-14);
  CHECK(probe(tree, 3.5, 2.5, 7.5, 0.25).count == 0);
  CHECK(probe(tree, 3.46, 2, 7, 0.25).count == 0); /* overlaps by 0.04: within the tolerance */
  CHECK(probe(tree, 3.1, 2, 7, 0).count == 1);     /* a point */
  CHECK(probe(tree, -100, 0, 0, 1).count == 0);
  /* 7 sites within a unit of one, 19 within the root of two, 27 in the cube around it */
  CHECK(probe(tree, 4, 4, 4, 0.81).count == 7);
  CHECK(probe(tree, 4, 4, 4, 1.22).count == 19);
  CHECK(probe(tree, 4, 4, 4, 1.54).count == 27);
  CHECK(probe(tree, 4, 4, 4, 100).count == SITES);
  const double nowhere[] = {0, INFINITY, 0};
  const double elsewhere[] = {0, 0, -INFINITY, NAN, 0, 0};
  const double origin[] = {0, 0, 0};
  CHECK_FAILURE(tree, ctInvalidArgument, "position", ctForEachClashWith(tree, nowhere, 1, note, &found, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "position", ctForEachClashWith(tree, elsewhere, 1, note, &found, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "position", ctForEachClashWith(tree, elsewhere + 3, 1, note, &found, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "radius", ctForEachClashWith(tree, origin, INFINITY, note, &found, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "radius", ctForEachClashWith(tree, origin, -1, note, &found, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "radius", ctForEachClashWith(tree, origin, NAN, note, &found, NULL));
  ctDestroy(tree);
}

/* It meets particles where they are now. */
static void testMoved(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.25, 0);
  const ctChange change = {.link = SIDE - 1, .rotation = {0, 0, PI / 2}, .translation = {0, 0, 50}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK(probe(tree, -3, 2, 58, 0.1).count == 0);
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK(probe(tree, 2, 3, 8, 0.1).count == 0);
  CHECK(probe(tree, -3, 2, 58, 0.1).particle == siteIndex(2, 3, 8));
  ctDestroy(tree);
}

/* What touches does not overlap. */
static void testTouching(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.25, 0);
  CHECK(probe(tree, 4.5, 4, 4, 0.25).count == 0);
  CHECK(probe(tree, 4.5, 4, 4, 0.25 + 0x1p-53).count == 2);
  CHECK(probe(tree, 4.5, 4, 4, 0.25 - 0x1p-53).count == 0);
  ctDestroy(tree);
}

int main(void) {
  for (int links = 0; links < latticeLinkings; links++) {
    testLattice(links);
  }
  testMoved();
  testTouching();
  return checkResult();
}
