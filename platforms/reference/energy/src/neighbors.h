/* Pairs of leaves that are near each other, with what is kept of each: before a trial, and in it. */
#ifndef CT_NEIGHBORS_H_
#define CT_NEIGHBORS_H_

#include "cachelines.h"
#include "ctenergy.h"

/* What is kept of leaves a <= b. A trial that is accepted makes its record that of the state by a flip. */
typedef struct PairRecord {
  double energy;
  bool hasPairs;                    /* else the energy and derivatives are 0, whatever is written there */
  bool hasBorn;                     /* the same of Born sums */
  float born[2][CT_LEAF_WIDTH];     /* what b contributes to the Born sums of a's particles, and a to b's */
  float gradient[2][CT_LEAF_WIDTH]; /* dE / d ln B of a's particles, and of b's, by this pair */
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
  PairRecord (*records)[2]; /* per pair */
  uint8_t* present;         /* per pair: which of both is that of the state */
  int64_t* stamp;           /* per pair: the last trial that has computed its other record */
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

/* Gives out a number for a pair, with an empty record of the state; CT_NULL if there is no memory. */
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

/* The record of the state, and the other one. */
static inline PairRecord* stateRecord(const Neighbors* neighbors, int pair) {
  return &neighbors->records[pair][neighbors->present[pair]];
}

static inline PairRecord* otherRecord(const Neighbors* neighbors, int pair) {
  return &neighbors->records[pair][1 - neighbors->present[pair]];
}

/* Asks for a record that is read soon. */
static inline void fetchRecord(const PairRecord* record) {
  for (size_t at = 0; at < sizeof *record; at += CACHE_LINE) {
    __builtin_prefetch((const char*)record + at);
  }
}

#endif /* CT_NEIGHBORS_H_ */
