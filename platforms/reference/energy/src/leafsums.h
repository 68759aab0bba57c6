/* A number for each pair of leaves that are near each other: the sum of its pairs of particles. Pairs that are not kept
 * have the sum 0. */
#ifndef CT_LEAFSUMS_H_
#define CT_LEAFSUMS_H_

#include <stdbool.h>
#include <stddef.h>

/* The pairs whose lower leaf is the same. */
typedef struct LeafRow {
  int count;
  int capacity;
  int cursor;   /* where the last pair was found: the next one mostly follows */
  int* leaves;  /* the higher leaf of each, ascending */
  double* sums; /* of each */
} LeafRow;

typedef struct LeafSums {
  int leafCount;
  LeafRow* rows; /* one a leaf */
} LeafSums;

/* False if there is no memory. */
bool ctLeafSumsCreate(LeafSums* sums, int leafCount);
void ctLeafSumsFree(LeafSums* sums);

/* Forgets all. */
void ctLeafSumsClear(LeafSums* sums);

/* The sum of a pair, a <= b. O(1) for pairs in ascending order, else O(log of the row). */
double ctLeafSumsGet(LeafSums* sums, int a, int b);

/* Replaces the sum of a pair, a <= b. False, and nothing changed, if there is no memory. O(row) where it was not kept.
 */
bool ctLeafSumsSet(LeafSums* sums, int a, int b, double sum);

/* The sum of all, in a fixed order. */
double ctLeafSumsTotal(const LeafSums* sums);

#endif /* CT_LEAFSUMS_H_ */
