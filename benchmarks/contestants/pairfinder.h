/* What the driver sees of a contestant that lists the pairs of particles within a cutoff. */
#ifndef PAIRFINDER_H_
#define PAIRFINDER_H_

#include <stdlib.h>

#include "contestant.h"

/* Pairs as two columns; distances only if they were asked for. */
typedef struct PairList {
  int count;
  int capacity;
  int* first;
  int* second;
  double* distances;
} PairList;

/* What a finder leaves in a list. */
typedef enum PairOrder {
  pairsInAnyOrder, /* without distances */
  pairsSorted      /* by the lower index, then the higher one, lower index first; with distances */
} PairOrder;

typedef struct PairFinder {
  const char* name;
  const char* idea; /* one line about it */
  PairOrder order;

  /* NULL if there is no memory. */
  void* (*make)(const Scene* scene);
  void (*destroy)(void* self);

  /* Lists the pairs at most `cutoff` apart, centre to centre, of particles at these 3 * particleCount coordinates, none
   * excluded; whatever is built for it is built here. False if there is no memory. */
  bool (*find)(void* self, const double* positions, double cutoff, PairList* list);
} PairFinder;

static inline bool pairListGrow(void** column, size_t size) {
  void* grown = realloc(*column, size);
  if (grown != NULL) {
    *column = grown;
  }
  return grown != NULL;
}

/* Room for that many pairs more, and some beyond the last that may be overwritten; false if there is no memory. */
static inline bool pairListReserve(PairList* list, int more) {
  enum { BEYOND = 64 };
  if (list->count + more <= list->capacity) {
    return true;
  }
  const int capacity = 2 * (list->count + more);
  const size_t count = (size_t)capacity + BEYOND;
  if (!pairListGrow((void**)&list->first, count * sizeof(int)) ||
      !pairListGrow((void**)&list->second, count * sizeof(int)) ||
      !pairListGrow((void**)&list->distances, count * sizeof(double))) {
    return false;
  }
  list->capacity = capacity;
  return true;
}

static inline void pairListFree(PairList* list) {
  free(list->first);
  free(list->second);
  free(list->distances);
  *list = (PairList){0};
}

#endif /* PAIRFINDER_H_ */
