/* pairs.h: lists of pairs, as the engine's callbacks fill them. */
#ifndef PAIRS_H_
#define PAIRS_H_

#include <stdbool.h>

typedef struct Pair {
    int particles[2];
    double values[2];
} Pair;

typedef struct PairList {
    int count, room;
    int end; /* a callback ends its query with this many pairs; 0: never */
    Pair* pairs;
} PairList;

void appendPair(PairList* list, int particle1, int particle2, double value1, double value2);

/* Sorts by particles; returns a pair that is there twice, or NULL. */
const Pair* sortPairs(PairList* list);

int comparePairs(const void* a, const void* b);

/* A pair of a sorted list, or NULL. */
const Pair* findPair(const PairList* list, int particle1, int particle2);

/* Callbacks, for which the list is the context; a particle is listed as the pair of it and itself. */
bool collectPair(void* list, int particle1, int particle2, double value);
bool collectChangedPair(void* list, int particle1, int particle2, double before, double after);
bool collectParticle(void* list, int particle, double overlap);

#endif /* PAIRS_H_ */
