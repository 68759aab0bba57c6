/* Records of pairs of leaves: an index that is used again holds no data of its former pair, whether that pair was
 * released or all were, and records do not change when the array grows. Looks inside the energy. */
#include "../../chaintree/tests/check.h"
#include "../src/neighbors.h"

enum { LEAVES = 300 };

static void fill(PairRecord* record, int number) {
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    record->born[0][k] = (float)number;
    record->born[1][k] = (float)(number + k);
    record->gradient[0][k] = (float)-number;
    record->gradient[1][k] = (float)(number - k);
  }
  record->energy = number;
  record->trial = number;
  record->hasPairs = record->hasBorn = true;
}

static bool isFilled(const PairRecord* record, int number) {
  PairRecord expected;
  fill(&expected, number);
  return memcmp(record->born, expected.born, sizeof record->born) == 0 &&
         memcmp(record->gradient, expected.gradient, sizeof record->gradient) == 0 && record->energy == number &&
         record->trial == number && record->hasPairs && record->hasBorn;
}

static const int noImage[3];

static bool isEmpty(const PairRecord* record) {
  const float none[CT_LEAF_WIDTH] = {0};
  bool isZero = record->energy == 0 && record->trial == 0;
  for (int side = 0; side < 2; side++) {
    isZero = isZero && memcmp(bornOf(record, side), none, sizeof none) == 0 &&
             memcmp(gradientOf(record, side), none, sizeof none) == 0;
  }
  return isZero;
}

static void testNumbers(void) {
  Neighbors neighbors;
  CHECK(ctNeighborsCreate(&neighbors, LEAVES));
  for (int round = 0; round < 2; round++) {
    /* Far more than there is room for at first. */
    for (int leaf = 0; leaf < LEAVES; leaf++) {
      const int pair = ctNeighborsReserve(&neighbors, noImage);
      CHECK(pair == leaf);
      CHECK(isEmpty(&neighbors.records[pair]));
      CHECK((uintptr_t)&neighbors.records[pair] % CACHE_LINE == 0);
      fill(&neighbors.records[pair], leaf);
      CHECK(ctNeighborsAdd(&neighbors, 0, leaf, pair));
    }
    for (int leaf = 0; leaf < LEAVES; leaf++) {
      const int pair = ctNeighborsFind(&neighbors, leaf, 0, noImage);
      CHECK(pair == leaf && isFilled(&neighbors.records[pair], leaf));
    }
    ctNeighborsRemove(&neighbors, 0, 7, 7);
    CHECK(ctNeighborsFind(&neighbors, 0, 7, noImage) == CT_NULL &&
          ctNeighborsFind(&neighbors, 7, 0, noImage) == CT_NULL);
    ctNeighborsRelease(&neighbors, 7);
    CHECK(ctNeighborsReserve(&neighbors, noImage) == 7);
    CHECK(isEmpty(&neighbors.records[7]));
    ctNeighborsRelease(&neighbors, 7);
    ctNeighborsClear(&neighbors, false);
    CHECK(ctNeighborsFind(&neighbors, 0, 0, noImage) == CT_NULL);
  }
  ctNeighborsFree(&neighbors);
}

static void testCopies(void) {
  Neighbors original;
  Neighbors copy;
  CHECK(ctNeighborsCreate(&original, LEAVES) && ctNeighborsCreate(&copy, LEAVES));
  for (int leaf = 0; leaf < LEAVES; leaf++) {
    const int pair = ctNeighborsReserve(&original, noImage);
    fill(&original.records[pair], leaf);
    CHECK(ctNeighborsAdd(&original, leaf, leaf, pair));
  }
  ctNeighborsRelease(&original, 7);
  CHECK(ctNeighborsCopy(&copy, &original));
  fill(&original.records[9], 1000);
  for (int leaf = 0; leaf < LEAVES; leaf++) {
    CHECK(ctNeighborsFind(&copy, leaf, leaf, noImage) == leaf && isFilled(&copy.records[leaf], leaf));
  }
  CHECK(ctNeighborsReserve(&copy, noImage) == 7);
  CHECK(ctNeighborsReserve(&copy, noImage) == LEAVES);
  ctNeighborsFree(&original);
  ctNeighborsFree(&copy);
}

/* Pairs of the same leaves in many images, added and removed in another order. */
static void testImages(void) {
  enum { SIDE = 3, IMAGES = SIDE * SIDE * SIDE };
  Neighbors neighbors;
  CHECK(ctNeighborsCreate(&neighbors, LEAVES));
  ctNeighborsClear(&neighbors, true);
  int pairs[IMAGES];
  for (int i = 0; i < IMAGES; i++) {
    const int n = 5 * i % IMAGES;
    const int image[3] = {n % SIDE - 1, n / SIDE % SIDE - 1, n / SIDE / SIDE - 1};
    pairs[n] = ctNeighborsReserve(&neighbors, image);
    CHECK(ctNeighborsAdd(&neighbors, 2, i % 2 == 0 ? 3 : 2, pairs[n]));
  }
  for (int round = 0; round < 2; round++) {
    for (int i = 0; i < IMAGES; i++) {
      const int n = 5 * i % IMAGES;
      const int image[3] = {n % SIDE - 1, n / SIDE % SIDE - 1, n / SIDE / SIDE - 1};
      const int partner = i % 2 == 0 ? 3 : 2;
      const int expected = round == 1 && i % 3 == 0 ? CT_NULL : pairs[n];
      CHECK(ctNeighborsFind(&neighbors, 2, partner, image) == expected);
      CHECK(partner == 2 || ctNeighborsFind(&neighbors, 3, 2, image) == expected);
      CHECK(ctNeighborsFind(&neighbors, 2, 5 - partner, image) == CT_NULL);
      if (round == 0 && i % 3 == 0) {
        ctNeighborsRemove(&neighbors, 2, partner, pairs[n]);
      }
    }
  }
  ctNeighborsFree(&neighbors);
}

int main(void) {
  testImages();
  testNumbers();
  testCopies();
  return checkResult();
}
