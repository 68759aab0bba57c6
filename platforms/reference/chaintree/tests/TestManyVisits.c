/* The counts of a descent exceed an int where many leaves are near each other and boxes separate them: the cost of a
 * test is computed in 64 bits. The sanitized run checks this. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "check.h"

enum { SIDE = 124, RODS = SIDE * SIDE, LINKS = RODS + 2, ROD = 16, PARTICLES = ROD * RODS + 2 };

static double positions[3 * PARTICLES];
static double radii[PARTICLES];
static int particleLinks[PARTICLES];
static int parents[LINKS];
static uint8_t joints[LINKS];
static ctChange changes[RODS];

/* Parallel rods on a grid, each a leaf, that hang on two carriers in turn. */
static ctChainTree* makeRods(void) {
  for (int link = 0; link < LINKS; link++) {
    joints[link] = ctFreeJoint;
    parents[link] = link < 2 ? CT_NULL : link % 2;
  }
  for (int carrier = 0; carrier < 2; carrier++) {
    particleLinks[carrier] = carrier;
    positions[3 * carrier + 1] = -100 - 20 * carrier;
  }
  for (int p = 2; p < PARTICLES; p++) {
    const int rod = (p - 2) / ROD;
    particleLinks[p] = rod + 2;
    positions[3 * p] = 5.0 * (p % ROD);
    positions[3 * p + 1] = 0.2 * (rod % SIDE);
    positions[3 * p + 2] = 0.2 * (rod / SIDE);
    radii[p] = 0.02;
  }
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = LINKS,
                                   .linkParents = parents,
                                   .linkJoints = joints};
  return checkedCreate(&definition);
}

/* Mixes the rods' places, so that the boxes of nodes over several rods part none of them. */
static void mix(ctChainTree* tree) {
  static int places[RODS];
  unsigned chance = 1;
  for (int i = 0; i < RODS; i++) {
    chance = chance * 1664525u + 1013904223u;
    const int k = (int)((chance >> 8) % (unsigned)(i + 1));
    places[i] = places[k];
    places[k] = i;
  }
  for (int i = 0; i < RODS; i++) {
    changes[i] = (ctChange){
        .link = i + 2, .translation = {0, 0.2 * (places[i] % SIDE - i % SIDE), 0.2 * (places[i] / SIDE - i / SIDE)}};
  }
  CHECK_SUCCESS(ctPropose(tree, RODS, changes));
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

int main(void) {
  setenv("CHAINTREE_TRIALS", "boxes", 1);
  ctChainTree* tree = makeRods();
  mix(tree);
  ctCounts counts = {0};
  bool clash = true;
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = 1, .translation = {0.01}}));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, &counts));
  CHECK(!clash && counts.volumeTests > INT32_MAX / 10);
  ctDestroy(tree);
  return checkResult();
}
