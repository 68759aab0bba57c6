/* What the driver sees of a contestant that lists the pairs of particles within a cutoff. */
#ifndef PAIRFINDER_H_
#define PAIRFINDER_H_

#include "contestant.h"

/* Pairs as two columns, in any order. */
typedef struct PairList {
  int count;
  int capacity;
  int* first;
  int* second;
} PairList;

typedef struct PairFinder {
  const char* name;
  const char* idea; /* one line about it */
  void* (*make)(const Scene* scene);
  void (*destroy)(void* self);

  /* Lists the pairs at most `cutoff` apart, centre to centre, of particles at these 3 * particleCount coordinates, none
   * excluded; whatever is built for it is built here. */
  void (*find)(void* self, const double* positions, double cutoff, PairList* list);
} PairFinder;

/* Room for more pairs, and some beyond the last that may be overwritten. */
static inline void pairListReserve(PairList* list, int more) {
  enum { BEYOND = 64 };
  if (list->count + more > list->capacity) {
    list->capacity = 2 * (list->count + more);
    list->first = reallocate(list->first, list->capacity + BEYOND, sizeof(int));
    list->second = reallocate(list->second, list->capacity + BEYOND, sizeof(int));
  }
}

static inline void pairListFree(PairList* list) {
  free(list->first);
  free(list->second);
}

#endif /* PAIRFINDER_H_ */
