/* A number for each pair of leaves that are near each other: the sum of its pairs of particles. And of some pairs of
 * leaves, what each section of the one has with each of the other, of which this is the sum. Numbers are kept as
 * multiples of EXACT_STEP. Pairs that are not kept have nothing but zeros. */
#ifndef CT_SECTIONSUMS_H_
#define CT_SECTIONSUMS_H_

#include "leafsections.h"

/* That of exactsums.h. */
#define EXACT_STEP 0x1p-30

/* No index. */
enum { NOT_KEPT = -1 };

/* What each section of the first leaf has with each of the second. */
typedef struct SectionTable {
  int64_t sums[MOST_SECTIONS][MOST_SECTIONS];
} SectionTable;

typedef enum PairKnowledge {
  NOTHING_THERE, /* all zeros: to be removed one day */
  SUM_KNOWN,
  SECTIONS_KNOWN,
  SUM_INEXACT /* it is no multiple, or too large */
} PairKnowledge;

/* What a pair of leaves has. */
typedef struct PairSum {
  PairKnowledge knowledge;
  union {
    int64_t exact;
    double inexact;
  } sum;
} PairSum;

static inline double sumOfPair(const PairSum* pair) {
  return pair->knowledge == SUM_INEXACT ? pair->sum.inexact : (double)pair->sum.exact * EXACT_STEP;
}

typedef struct KeptPair {
  int table; /* NOT_KEPT unless sections are known; of a pair that is free, the next one */
  PairSum sum;
} KeptPair;

/* The pairs of a leaf. */
typedef struct SectionRow {
  int count;
  int capacity;
  int cursor;  /* where the next pair to be looked for may be */
  int* leaves; /* the other one of each, ascending */
  int* kept;   /* its index in the pairs */
} SectionRow;

typedef struct SectionSums {
  int leafCount;
  SectionRow* rows; /* one a leaf; a pair of two leaves is in both */
  int pairCount;
  int pairCapacity;
  int freePair;
  KeptPair* pairs;
  int tableCount;
  int tableCapacity;
  int freeTable;
  SectionTable* tables;
} SectionSums;

/* False if there is no memory. */
bool ctSectionSumsCreate(SectionSums* sums, int leafCount);
void ctSectionSumsFree(SectionSums* sums);

/* Forgets all. */
void ctSectionSumsClear(SectionSums* sums);

/* The index of the pair of two leaves, or NOT_KEPT. It holds until a pair is added. O(log of the row of the first),
 * less if pairs of a leaf are asked for one after the other, ascending. */
int ctSectionSumsSearch(SectionSums* sums, int leaf, int other);

static inline int sectionSumsFind(SectionSums* sums, int leaf, int other) {
  SectionRow* row = &sums->rows[leaf];
  const int next = row->cursor;
  if (next >= row->count || row->leaves[next] != other) {
    return ctSectionSumsSearch(sums, leaf, other);
  }
  row->cursor = next + 1;
  return row->kept[next];
}

/* Sets what a pair has, which is added if `kept` is NOT_KEPT. Of the table, which is that of known sections, the rows
 * that are bits of `changed` are taken over; with `isTransposed` columns are, of a table that has these as rows. False
 * if there is no memory; all has to be computed anew then. */
bool ctSectionSumsSet(SectionSums* sums, int a, int b, int kept, const PairSum* sum, const SectionTable* table,
                      unsigned changed, bool isTransposed);

/* Makes `to`, which is of as many leaves, a copy. False if there is no memory; it can be used and freed all the same.
 * Where `to` has held as much before, none is needed. */
bool ctSectionSumsCopy(const SectionSums* from, SectionSums* to);

/* The sum of all, in an order of the leaves. */
double ctSectionSumsTotal(const SectionSums* sums);

#endif /* CT_SECTIONSUMS_H_ */
