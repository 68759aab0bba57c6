/* Every allocation for a whole energy fails once: the call says so, leaves nothing behind, and succeeds the next time.
 */
#include "../../chaintree/tests/failingallocator.h"

#ifndef HAS_GLIBC_ALLOCATOR

int main(void) {
  return 77;
}

#else

#include "wholescene.h"

int main(void) {
  static WholeScene scene;
  static int slotOf[MOST_PARTICLES];
  static double sums[MOST_PARTICLES];
  double expected[2];
  double found[2];
  printf("\n"); /* its buffer is no leak of ours */
  do {
    drawWholeScene(&scene);
  } while (scene.count < 50 || scene.born.neckTypeCount == 0 || !scene.born.isRescaled);
  int refused = 0;
  bool goesOn = true;
  for (int n = -1; goesOn; n++) {
    char text[100] = "";
    WholeEnergy whole;
    ctChainTree* tree = createTree(&scene);
    findWholeSlots(tree, slotOf);
    const int before = live;
    hasFailed = false;
    if (n >= 0) {
      failAllocation(n);
    }
    ctStatus status =
        ctWholeEnergyCreate(&whole, tree, scene.count, &scene.nonbonded, &scene.born, slotOf, text, sizeof text);
    allocationsLeft = -1;
    goesOn = n < 0 || hasFailed;
    if (status != ctSuccess) {
      refused++;
      CHECK(hasFailed && status == ctOutOfMemory && strcmp(text, "out of memory") == 0);
      CHECK(live == before);
      status = ctWholeEnergyCreate(&whole, tree, scene.count, &scene.nonbonded, &scene.born, slotOf, text, sizeof text);
      CHECK(status == ctSuccess);
    }
    double* energies = n < 0 ? expected : found;
    failAllocation(0); /* computing may need memory of the scene, and says so */
    status = ctWholeEnergyCompute(&whole, &energies[0], &energies[1]);
    allocationsLeft = -1;
    CHECK(status == ctSuccess || (hasFailed && status == ctOutOfMemory));
    CHECK(ctWholeEnergyCompute(&whole, &energies[0], &energies[1]) == ctSuccess);
    CHECK(ctWholeEnergyBornSums(&whole, sums) == ctSuccess);
    CHECK(n < 0 || memcmp(expected, found, sizeof found) == 0);
    ctWholeEnergyFree(&whole);
    ctDestroy(tree);
  }
  CHECK(refused > 8);
  return checkResult();
}

#endif
