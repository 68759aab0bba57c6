/* Chains are what they are said to be, and begin without a clash. */
#include <math.h>
#include <string.h>

#include "chains.h"
#include "check.h"
#include "rigid.h"

static double distance(const Scene* scene, int i, int j) {
  return sqrt(squaredDistance(scene->spheres[i].x, scene->spheres[j].x));
}

static void checkTorsions(const Scene* scene) {
  CHECK(scene->linkCount == scene->particleCount - 2);
  CHECK(scene->torsionCount == scene->particleCount - 3);
  for (int t = 0; t < scene->torsionCount; t++) {
    CHECK(scene->torsions[t].axis[0] == t + 1 && scene->torsions[t].axis[1] == t + 2);
    CHECK(scene->torsions[t].first == t + 2 && scene->torsions[t].last == scene->particleCount);
    CHECK(!scene->torsions[t].sideChain);
  }
}

static void checkChain(Scene* scene, int count) {
  CHECK(scene != NULL && scene->particleCount == count);
  checkTorsions(scene);
  for (int i = 0; i < count; i++) {
    CHECK(scene->particleNames[i] == i);
    CHECK(i == 0 || distance(scene, i - 1, i) <= 4 + 1e-12);
    for (int j = 0; j < i; j++) {
      CHECK(distance(scene, i, j) >= 4);
      CHECK(distance(scene, i, j) > scene->spheres[i].radius + scene->spheres[j].radius);
    }
  }
  sceneFree(scene);
}

/* Within the cube, and not the serpentine any more. */
static void testRandomness(void) {
  Random random = {5};
  Scene* serpentine = chainSerpentine(500);
  Scene* scene = chainRandom(500, &random);
  int straight = 0;
  for (int i = 0; i < 500; i++) {
    for (int k = 0; k < 3; k++) {
      CHECK(scene->spheres[i].x[k] >= 0 && scene->spheres[i].x[k] <= 4 * 7);
    }
    straight += i > 1 && distance(scene, i - 2, i) > 7.9;
  }
  CHECK(memcmp(serpentine->spheres, scene->spheres, 500 * sizeof(Sphere)) != 0);
  CHECK(straight < 250);
  sceneFree(serpentine);
  sceneFree(scene);
}

int main(void) {
  Random random = {1};
  const int counts[] = {4, 5, 27, 100, 512, 700};
  for (int i = 0; i < 6; i++) {
    checkChain(chainSerpentine(counts[i]), counts[i]);
    checkChain(chainHilbert(counts[i]), counts[i]);
    checkChain(chainRandom(counts[i], &random), counts[i]);
  }
  testRandomness();
  return checkResult();
}
