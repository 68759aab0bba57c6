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

/* Whether some searcher overlaps a particle of the lists that counts and is not excluded. Ends the search. */
__attribute__((always_inline)) static inline bool searchMeets(Search* search, const Cells* cells, const Scene* scene,
                                                              const Sphere* spheres, CellsFilter* filter,
                                                              const void* context, int64_t* particleTests) {
  int count = search->candidateCount;
  bool meets = false;
  while (count > 0 && !meets) {
    int left = 0;
    *particleTests += count;
    for (int k = 0; k < count; k++) {
      const int searcher = search->searchers[k];
      const int j = search->candidates[k];
      const Sphere* sphere = &search->spheres[searcher];
      const double sum = sphere->radius + spheres[j].radius;
      const int next = cells->next[j];
      search->searchers[left] = searcher;
      search->candidates[left] = next;
      left += next >= 0;
      /* One branch, rarely taken; of two, the processor would often guess one wrong. */
      const double limit = sum * sum * (double)filter(context, j);
      if (squaredDistance(sphere->x, spheres[j].x) < limit && !sceneExcludes(scene, search->particles[searcher], j)) {
        meets = true;
        break;
      }
    }
    count = left;
  }
  search->count = 0;
  search->candidateCount = 0;
  return meets;
}

#endif /* BATCHSEARCH_H_ */
