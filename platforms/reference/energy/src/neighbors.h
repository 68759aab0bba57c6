/* Pairs of leaves that are near each other, in each periodic image, and a record of each. */
#ifndef CT_NEIGHBORS_H_
#define CT_NEIGHBORS_H_

#include "cachelines.h"
#include "ctenergy.h"

/* The record of leaves a <= b in the state, or in a trial. Each part begins at a cache line. */
typedef struct PairRecord {
  _Alignas(CACHE_LINE) float born[2][CT_LEAF_WIDTH]; /* contributions of b to the Born sums of a's particles, and of a
                                                        to those of b's */
  float gradient[2][CT_LEAF_WIDTH];                  /* dE / d ln B of a's particles, and of b's, by this pair */
  double energy;
  int64_t trial; /* of a record of the state: the last trial that recomputed it */
  bool hasPairs; /* if false, the energy and derivatives count as 0 */
  bool hasBorn;  /* the same of Born sums */
  uint8_t moves; /* how often displaced particles have changed it since it was computed */
  int image[3];  /* the numbers of box vectors by which a is shifted */
} PairRecord;

/* The neighbours of a leaf, ascending, and of one leaf by its images. */
typedef struct NeighborRow {
  int count;
  int capacity;
  int* leaves;
  int* pairs; /* the number of the pair with each */
} NeighborRow;

typedef struct Neighbors {
  int leafCount;
  bool hasImages;
  NeighborRow* rows; /* one a leaf; each pair is in both */
  int pairCount;     /* numbers given out, of which freeCount are free again */
  int pairCapacity;
  PairRecord* records; /* per pair */
  int freeCount;
  int* free; /* per pair: numbers that are free */
} Neighbors;

/* False if there is no memory. */
bool ctNeighborsCreate(Neighbors* neighbors, int leafCount);
void ctNeighborsFree(Neighbors* neighbors);

/* Removes all pairs. Pairs that are added afterwards may have images, or have none. */
void ctNeighborsClear(Neighbors* neighbors, bool hasImages);

/* The number of the pair of leaves a and b in an image, whose lower leaf is shifted, or CT_NULL. O(log of the row). */
int ctNeighborsFind(const Neighbors* neighbors, int a, int b, const int image[3]);

/* Gives out a number for a pair in an image, with an empty record; CT_NULL if there is no memory. */
int ctNeighborsReserve(Neighbors* neighbors, const int image[3]);

/* Frees the number of a pair that is in no row. */
void ctNeighborsRelease(Neighbors* neighbors, int pair);

/* Adds a pair to the rows of its leaves, or removes it. Adding is false, and nothing changed, if there is no memory.
 * O(rows). */
bool ctNeighborsAdd(Neighbors* neighbors, int a, int b, int pair);
void ctNeighborsRemove(Neighbors* neighbors, int a, int b, int pair);

/* Makes one a copy of another for as many leaves. False if there is no memory; then the copy is of no use. */
bool ctNeighborsCopy(Neighbors* copy, const Neighbors* original);

/* The Born sums or derivatives of one leaf of a record, or sixteen zeros. */
static inline const float* bornOf(const PairRecord* record, int side) {
  static const float none[CT_LEAF_WIDTH];
  return record->hasBorn ? record->born[side] : none;
}

static inline const float* gradientOf(const PairRecord* record, int side) {
  static const float none[CT_LEAF_WIDTH];
  return record->hasPairs ? record->gradient[side] : none;
}

/* Copies the energy and derivatives of a record, and its Born sums: in parts, which compilers copy by vectors. They
 * copy a whole record by an instruction that is slow to start. */
static inline void copyPairs(const PairRecord* from, PairRecord* to) {
  to->energy = from->energy;
  to->hasPairs = from->hasPairs;
  to->moves = from->moves;
  memcpy(to->gradient, from->gradient, sizeof to->gradient);
}

static inline void copyBorn(const PairRecord* from, PairRecord* to) {
  to->hasBorn = from->hasBorn;
  memcpy(to->born, from->born, sizeof to->born);
}

/* Prefetches the energy and derivatives of a record, which is read soon, and its Born sums. */
static inline void fetchPairs(const PairRecord* record) {
  __builtin_prefetch(record->gradient[0]);
  __builtin_prefetch(record->gradient[1]);
  __builtin_prefetch(&record->energy);
}

static inline void fetchBorn(const PairRecord* record) {
  __builtin_prefetch(record->born[0]);
  __builtin_prefetch(record->born[1]);
}

#endif /* CT_NEIGHBORS_H_ */
