/* Searches in a grid of cells for several particles at once.
 *
 * How many particles a cell holds cannot be foreseen, and a processor that guesses wrong waits. So the cells around all
 * of them are looked up before any distance is tested, and then all lists are gone through side by side. */
#ifndef BATCHSEARCH_H_
#define BATCHSEARCH_H_

#include "cells.h"

enum { SEARCHERS = 16 };

/* Some particles that search for others near them. */
typedef struct Search {
  int count; /* of searchers */
  int particles[SEARCHERS];
  Sphere spheres[SEARCHERS]; /* where they are */
  int candidateCount;
  int searchers[SEARCHERS * MOST_CELLS_AROUND]; /* of each candidate */
  int candidates[SEARCHERS * MOST_CELLS_AROUND];
} Search;

/* Adds a searcher, and what the cells around it begin with. */
static inline void searchAdd(Search* search, const Cells* cells, int particle, const Sphere* sphere) {
  const CellsAround around = cellsAround(cells, sphere);
  const int along = cells->along;
  int count = search->candidateCount;
  for (int z = 0; z < along; z++) {
    for (int y = 0; y < along; y++) {
      for (int x = 0; x < along; x++) {
        const int head = cells->heads[around.parts[0][x] | around.parts[1][y] | around.parts[2][z]];
        search->searchers[count] = search->count;
        search->candidates[count] = head;
        count += head >= 0;
      }
    }
  }
  search->candidateCount = count;
  search->particles[search->count] = particle;
  search->spheres[search->count++] = *sphere;
}

static inline void searchEnd(Search* search) {
  search->count = 0;
  search->candidateCount = 0;
}

/* What to do with a pair that a search finds; true ends it. */
typedef bool SearchFound(void* context, int searcher, int j);

/* Finds the pairs of a searcher and a particle of the lists that counts whose distance is below the sum of their radii
 * and `room`. Ends the search, and returns whether `found` did. */
__attribute__((always_inline)) static inline bool searchFind(Search* search, const Cells* cells, const Sphere* spheres,
                                                             double room, CellsFilter* filter, SearchFound* found,
                                                             void* context, int64_t* particleTests) {
  int count = search->candidateCount;
  bool ended = false;
  while (count > 0 && !ended) {
    int left = 0;
    *particleTests += count;
    for (int k = 0; k < count; k++) {
      const int searcher = search->searchers[k];
      const int j = search->candidates[k];
      const Sphere* sphere = &search->spheres[searcher];
      const double sum = sphere->radius + spheres[j].radius + room;
      const int next = cells->next[j];
      search->searchers[left] = searcher;
      search->candidates[left] = next;
      left += next >= 0;
      /* One branch, rarely taken; of two, the processor would often guess one wrong. */
      const double limit = sum * sum * (double)filter(context, j);
      if (squaredDistance(sphere->x, spheres[j].x) < limit && found(context, search->particles[searcher], j)) {
        ended = true;
        break;
      }
    }
    count = left;
  }
  searchEnd(search);
  return ended;
}

#endif /* BATCHSEARCH_H_ */
