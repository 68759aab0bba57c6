/* Memory of a scene of a million links, by the C library's own count: at most 160 bytes a particle beyond the caller's
 * arrays, and 80 more if it is flexible. Skipped with another allocator. */
#include "allocator.h"
#include "chain.h"

#ifdef HAS_GLIBC_ALLOCATOR
#if __GLIBC_PREREQ(2, 33)
#define HAS_COUNT
#endif
#endif

#ifndef HAS_COUNT

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
static ctChainTree* makeBeads(void) {
  const Chain chain = allocateChain(LINKS, LINKS, ctFreeJoint);
  for (int i = 0; i < LINKS; i++) {
    const int row = i / ROW;
    const int layer = row / ROW;
    const int along = row % 2 == 0 ? i % ROW : ROW - 1 - i % ROW;
    const int across = layer % 2 == 0 ? row % ROW : ROW - 1 - row % ROW;
    const double position[3] = {4 * along, 4 * across, 4 * layer};
    setBead(&chain, i, position, 1);
  }
  return createChain(&chain);
}

static void testMemory(double most) {
  const double before = bytesInUse();
  ctChainTree* beads = makeBeads();
  for (int trial = 0; trial < 100; trial++) {
    const ctChange change = {.link = 2 + trial * 9973, .angle = 0.1 * (1 + trial)};
    bool clash = false;
    CHECK_SUCCESS(ctPropose(beads, 1, &change));
    CHECK_SUCCESS(ctTestTrial(beads, &clash, NULL, NULL));
    if (!clash) {
      CHECK_SUCCESS(ctAccept(beads, NULL));
    }
  }
  const double kept = (bytesInUse() - before) / LINKS;
  CHECK(kept > 100); /* else it is not counted */
  CHECK(kept <= most);
  ctDestroy(beads);
}

int main(void) {
  testMemory(160);
  chainsAreFlexible = true;
  testMemory(240);
  return checkResult();
}

#endif
