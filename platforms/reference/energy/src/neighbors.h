/* Pairs of leaves that are near each other, with what is kept of each. */
#ifndef CT_NEIGHBORS_H_
#define CT_NEIGHBORS_H_

#include "cachelines.h"
#include "ctenergy.h"

/* What is kept of leaves a <= b, or what a trial makes of it. Each part lies in lines of its own. */
typedef struct PairRecord {
  _Alignas(CACHE_LINE) float born[2][CT_LEAF_WIDTH]; /* what b contributes to the Born sums of a's particles, and a to
                                                        b's */
  float gradient[2][CT_LEAF_WIDTH];                  /* dE / d ln B of a's particles, and of b's, by this pair */
  double energy;
  int64_t stamp; /* of what is kept: the last trial that computed it anew */
  bool hasPairs; /* else the energy and derivatives are 0, whatever is written there */
  bool hasBorn;  /* the same of Born sums */
} PairRecord;

/* The neighbours of a leaf, ascending. */
typedef struct NeighborRow {
  int count;
  int capacity;
  int* leaves;
  int* pairs; /* the number of the pair with each */
} NeighborRow;

typedef struct Neighbors {
  int leafCount;
  NeighborRow* rows; /* one a leaf; each pair is in both */
  int pairCount;     /* numbers that were given out, some of which may be free again */
  int pairCapacity;
  PairRecord* records; /* per pair */
  int freeCount;
  int* free; /* per pair: numbers that are free */
} Neighbors;

/* False if there is no memory. */
bool ctNeighborsCreate(Neighbors* neighbors, int leafCount);
void ctNeighborsFree(Neighbors* neighbors);

/* Forgets all pairs. */
void ctNeighborsClear(Neighbors* neighbors);

/* The number of the pair of leaves a and b, or CT_NULL. O(log of the row). */
int ctNeighborsFind(const Neighbors* neighbors, int a, int b);

/* Gives out a number for a pair, with an empty record; CT_NULL if there is no memory. */
int ctNeighborsReserve(Neighbors* neighbors);

/* Takes a number back that no row has. */
void ctNeighborsRelease(Neighbors* neighbors, int pair);

/* Writes a pair into the rows of its leaves, or takes it out. Adding is false, and nothing changed, if there is no
 * memory. O(rows). */
bool ctNeighborsAdd(Neighbors* neighbors, int a, int b, int pair);
void ctNeighborsRemove(Neighbors* neighbors, int a, int b);

/* Makes one a copy of another for as many leaves. False if there is no memory; then the copy is of no use. */
bool ctNeighborsCopy(Neighbors* copy, const Neighbors* original);

/* Sixteen zeros, or what a record has of one of its leaves. */
static inline const float* bornOf(const PairRecord* record, int side) {
  static const float none[CT_LEAF_WIDTH];
  return record->hasBorn ? record->born[side] : none;
}

static inline const float* gradientOf(const PairRecord* record, int side) {
  static const float none[CT_LEAF_WIDTH];
  return record->hasPairs ? record->gradient[side] : none;
}

/* Copies what a record has of pairs, and of Born sums: in parts, which compilers copy by vectors; a whole record they
 * copy by an instruction that takes long to begin. */
static inline void copyPairs(const PairRecord* from, PairRecord* to) {
  to->energy = from->energy;
  to->hasPairs = from->hasPairs;
  memcpy(to->gradient, from->gradient, sizeof to->gradient);
}

static inline void copyBorn(const PairRecord* from, PairRecord* to) {
  to->hasBorn = from->hasBorn;
  memcpy(to->born, from->born, sizeof to->born);
}

/* Asks for what a record has of pairs, which is read soon, and for the rest of it. */
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
