/* A number for each pair of leaves that are near each other: the sum of its pairs of particles. Pairs that are not kept
 * have the sum 0. */
#ifndef CT_LEAFSUMS_H_
#define CT_LEAFSUMS_H_

#include <stdbool.h>
#include <stddef.h>

/* No index. */
enum { ABSENT = -1 };

/* The pairs whose lower leaf is the same. */
typedef struct LeafRow {
  int count;
  int capacity;
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

/* The index in row a of the pair of a <= b, or ABSENT. It holds until a pair is added to the row. O(log of the row). */
int ctLeafSumsFind(const LeafSums* sums, int a, int b);

/* Adds a pair that is absent. False, and nothing changed, if there is no memory. O(row). */
bool ctLeafSumsAdd(LeafSums* sums, int a, int b, double sum);

/* Makes `to`, which is of as many leaves, a copy. False if there is no memory; it can be used and freed all the same.
 * Where every row of `to` has held as many pairs before, none is needed. */
bool ctLeafSumsCopy(const LeafSums* from, LeafSums* to);

/* The sum of all, in a fixed order. */
double ctLeafSumsTotal(const LeafSums* sums);

#endif /* CT_LEAFSUMS_H_ */
