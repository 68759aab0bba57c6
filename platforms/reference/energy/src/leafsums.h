/* A number for each pair of leaves that are near each other: the sum over its pairs of particles. The sum of a pair
 * that is absent is 0. */
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

/* Removes all pairs. */
void ctLeafSumsClear(LeafSums* sums);

/* The index in row a of the pair of a <= b, or ABSENT. It holds until a pair is added to the row. O(log of the row). */
int ctLeafSumsFind(const LeafSums* sums, int a, int b);

/* Adds a pair that is absent. False, and nothing changed, if there is no memory. O(row). */
bool ctLeafSumsAdd(LeafSums* sums, int a, int b, double sum);

/* Copies to sums of the same number of leaves. False if there is no memory; the copy can still be used and freed. A row
 * needs no memory if it has held as many pairs before. */
bool ctLeafSumsCopy(const LeafSums* from, LeafSums* to);

/* The sum of all, in a fixed order. */
double ctLeafSumsTotal(const LeafSums* sums);

#endif /* CT_LEAFSUMS_H_ */
