/* What a scene of a million links keeps, by the C library's own count: at most 160 bytes a particle beyond the caller's
 * arrays. Skipped where the allocator is another one. */
#include "check.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED
#endif
#ifdef __GLIBC__
#if __GLIBC_PREREQ(2, 33)
#define HAS_COUNT
#endif
#endif

#if defined(SANITIZED) || !defined(HAS_COUNT)

int main(void) {
  return 77;
}

#else

#include <malloc.h>

enum { LINKS = 1000000, ROW = 100 };

static double bytesInUse(void) {
  const struct mallinfo2 info = mallinfo2();
  return (double)info.uordblks + (double)info.hblkhd;
}

/* A bead a link, in rows and layers, each turning about the bond to the one before. */
static ctChainTree* makeBeads(double* bytes) {
  double* positions = calloc(LINKS, sizeof(double[3]));
  double* radii = calloc(LINKS, sizeof(double));
  int* particleLinks = calloc(LINKS, sizeof(int));
  int* parents = calloc(LINKS, sizeof(int));
  uint8_t* joints = calloc(LINKS, 1);
  int(*torsions)[4] = calloc(LINKS, sizeof *torsions);
  if (!positions || !radii || !particleLinks || !parents || !joints || !torsions) {
    abort();
  }
  for (int i = 0; i < LINKS; i++) {
    const int row = i / ROW;
    const int layer = row / ROW;
    const int along = row % 2 == 0 ? i % ROW : ROW - 1 - i % ROW;
    const int across = layer % 2 == 0 ? row % ROW : ROW - 1 - row % ROW;
    const double position[3] = {4 * along, 4 * across, 4 * layer};
    const int torsion[4] = {i > 1 ? i - 2 : 0, i - 1, i, i + 1 < LINKS ? i + 1 : i};
    memcpy(positions + 3 * (size_t)i, position, sizeof position);
    memcpy(torsions[i], torsion, sizeof torsion);
    radii[i] = 1;
    particleLinks[i] = i;
    parents[i] = i - 1;
    joints[i] = i == 0 ? ctFreeJoint : ctTorsionJoint;
  }
  const ctDefinition definition = {.particleCount = LINKS,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = LINKS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions};
  const double before = bytesInUse();
  ctChainTree* beads = checkedCreate(&definition);
  *bytes = bytesInUse() - before;
  free(positions);
  free(radii);
  free(particleLinks);
  free(parents);
  free(joints);
  free(torsions);
  return beads;
}

int main(void) {
  double built;
  ctChainTree* beads = makeBeads(&built);
  const double before = bytesInUse();
  for (int trial = 0; trial < 100; trial++) {
    const ctChange change = {.link = 2 + trial * 9973, .angle = 0.1 * (1 + trial)};
    bool clash = false;
    CHECK_SUCCESS(ctPropose(beads, 1, &change));
    CHECK_SUCCESS(ctTestTrial(beads, &clash, NULL, NULL));
    if (!clash) {
      CHECK_SUCCESS(ctCommit(beads, NULL));
    }
  }
  const double kept = (built + bytesInUse() - before) / LINKS;
  CHECK(kept > 100); /* else it is not counted */
  CHECK(kept <= 160);
  ctDestroy(beads);
  return checkResult();
}

#endif
