/* Searches in a grid of cells for one particle after the other. */
#ifndef PLAINSEARCH_H_
#define PLAINSEARCH_H_

#include "cells.h"

/* Whether particle i, at `sphere`, overlaps one in the grid that counts and is not excluded. */
__attribute__((always_inline)) static inline bool cellsMeet(const Cells* cells, const Scene* scene,
                                                            const Sphere* spheres, int i, const Sphere* sphere,
                                                            CellsFilter* filter, const void* context,
                                                            int64_t* particleTests) {
  const CellsAround around = cellsAround(cells, sphere);
  const int along = cells->along;
  for (int z = 0; z < along; z++) {
    for (int y = 0; y < along; y++) {
      for (int x = 0; x < along; x++) {
        const int entry = around.parts[0][x] | around.parts[1][y] | around.parts[2][z];
        for (int j = cells->heads[entry]; j >= 0; j = cells->next[j]) {
          const double sum = sphere->radius + spheres[j].radius;
          ++*particleTests;
          if (squaredDistance(sphere->x, spheres[j].x) < sum * sum && filter(context, j) &&
              !sceneExcludes(scene, i, j)) {
            return true;
          }
        }
      }
    }
  }
  return false;
}

#endif /* PLAINSEARCH_H_ */
