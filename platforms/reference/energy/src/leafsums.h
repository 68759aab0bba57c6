/* A number for each pair of leaves, in each image, that are near each other: the sum over its pairs of particles. The
 * sum of a pair that is absent is 0. */
#ifndef CT_LEAFSUMS_H_
#define CT_LEAFSUMS_H_

#include "ctenergy.h"

/* No index. */
enum { ABSENT = -1 };

/* The higher leaf of a pair, and the image of the lower: ascending by the leaf. */
typedef uint64_t LeafKey;

/* Bits of the number of each box vector. */
enum { IMAGE_BITS = 12 };

_Static_assert(CT_MOST_IMAGE < 1 << (IMAGE_BITS - 1), "images have to fit into keys");

static inline LeafKey leafKeyOf(int b, const int image[3]) {
  LeafKey key = (LeafKey)b;
  for (int d = 0; d < 3; d++) {
    key = key << IMAGE_BITS | (LeafKey)(image[d] + (1 << (IMAGE_BITS - 1)));
  }
  return key;
}

/* The pairs whose lower leaf is the same. */
typedef struct LeafRow {
  int count;
  int capacity;
  LeafKey* keys; /* of each, ascending */
  double* sums;  /* of each */
} LeafRow;

typedef struct LeafSums {
  int leafCount;
  LeafRow* rows; /* one a leaf */
} LeafSums;

/* False if there is no memory. */
bool ctLeafSumsCreate(LeafSums* sums, int leafCount);
void ctLeafSumsFree(LeafSums* sums);

/* Removes all pairs. */
void ctLeafSumsClear(LeafSums* sums);

/* The index in row a of the pair of a <= b with this key, or ABSENT. It holds until a pair is added to the row. O(log
 * of the row). */
int ctLeafSumsFind(const LeafSums* sums, int a, int b, LeafKey key);

/* Adds a pair that is absent. False, and nothing changed, if there is no memory. O(row). */
bool ctLeafSumsAdd(LeafSums* sums, int a, LeafKey key, double sum);

/* Copies to sums of the same number of leaves. False if there is no memory; the copy can still be used and freed. A row
 * needs no memory if it has held as many pairs before. */
bool ctLeafSumsCopy(const LeafSums* from, LeafSums* to);

/* The sum of all, in a fixed order. */
double ctLeafSumsTotal(const LeafSums* sums);

#endif /* CT_LEAFSUMS_H_ */
