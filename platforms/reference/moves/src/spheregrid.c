#include "spheregrid.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

/* nm. Smaller cubes have shorter lists, but their memory no longer fits into caches. */
#define WIDTH 0.2

#define MOST_CUBES 2000000

/* The cubes that a sphere may reach, in one dimension. */
static void rangeOf(const SphereGrid* grid, int k, double center, double reach, int* from, int* to) {
  const double first = floor((center - reach - grid->least[k]) / grid->width);
  const double last = floor((center + reach - grid->least[k]) / grid->width);
  *from = first > 0 ? (int)fmin(first, grid->counts[k]) : 0;
  *to = last < grid->counts[k] ? (int)fmax(last + 1, 0) : grid->counts[k];
}

/* The square of the distance of a point from a cube. */
static double distanceOf(const SphereGrid* grid, const int cube[3], const double x[3]) {
  double sum = 0;
  for (int k = 0; k < 3; k++) {
    const double low = grid->least[k] + cube[k] * grid->width;
    const double gap = fmax(fmax(low - x[k], x[k] - low - grid->width), 0);
    sum += gap * gap;
  }
  return sum;
}

/* Counts the spheres of each cube in firsts[cube + 1], or lists them. */
static void enter(SphereGrid* grid, int count, const Sphere* spheres, double reach, int* ends) {
  for (int i = 0; i < count; i++) {
    const double most = spheres[i].radius + reach;
    int from[3], to[3], cube[3];
    if (!(spheres[i].radius > 0 && most > 0)) {
      continue;
    }
    for (int k = 0; k < 3; k++) {
      rangeOf(grid, k, spheres[i].x[k], most, &from[k], &to[k]);
    }
    for (cube[0] = from[0]; cube[0] < to[0]; cube[0]++) {
      for (cube[1] = from[1]; cube[1] < to[1]; cube[1]++) {
        for (cube[2] = from[2]; cube[2] < to[2]; cube[2]++) {
          if (distanceOf(grid, cube, spheres[i].x) > most * most * (1 + 1e-9)) {
            continue;
          }
          const int index = (cube[0] * grid->counts[1] + cube[1]) * grid->counts[2] + cube[2];
          if (ends == NULL) {
            grid->firsts[index + 1]++;
          } else {
            grid->items[ends[index]++] = i;
          }
        }
      }
    }
  }
}

/* A sphere of a cube, and by how much it comes short of, or beyond, the middle of the cube. */
typedef struct Neighbor {
  double gap;
  int sphere;
} Neighbor;

static int compareGaps(const void* a, const void* b) {
  const Neighbor* first = a;
  const Neighbor* second = b;
  return first->gap != second->gap ? (first->gap < second->gap ? -1 : 1) : first->sphere - second->sphere;
}

/* Sorts the lists: what is deepest in a cube is met most often, so a test ends sooner. */
static bool sortLists(SphereGrid* grid, const Sphere* spheres) {
  int most = 0, index = 0, cube[3];
  for (int i = 0; i < grid->counts[0] * grid->counts[1] * grid->counts[2]; i++) {
    const int count = grid->firsts[i + 1] - grid->firsts[i];
    most = count > most ? count : most;
  }
  Neighbor* list = malloc(((size_t)most + 1) * sizeof *list);
  for (cube[0] = 0; list != NULL && cube[0] < grid->counts[0]; cube[0]++) {
    for (cube[1] = 0; cube[1] < grid->counts[1]; cube[1]++) {
      for (cube[2] = 0; cube[2] < grid->counts[2]; cube[2]++, index++) {
        int* items = grid->items + grid->firsts[index];
        const int count = grid->firsts[index + 1] - grid->firsts[index];
        for (int i = 0; i < count; i++) {
          const Sphere* sphere = &spheres[items[i]];
          double square = 0;
          for (int k = 0; k < 3; k++) {
            const double side = sphere->x[k] - grid->least[k] - (cube[k] + 0.5) * grid->width;
            square += side * side;
          }
          list[i] = (Neighbor){sqrt(square) - sphere->radius, items[i]};
        }
        qsort(list, (size_t)count, sizeof *list, compareGaps);
        for (int i = 0; i < count; i++) {
          items[i] = list[i].sphere;
        }
      }
    }
  }
  const bool isSorted = list != NULL;
  free(list);
  return isSorted;
}

bool makeSphereGrid(int count, const Sphere* spheres, const double center[3], double radius, double reach,
                    SphereGrid* grid) {
  double cubes = 1;
  grid->width = WIDTH;
  for (;;) {
    cubes = 1;
    for (int k = 0; k < 3; k++) {
      cubes *= ceil(2 * radius / grid->width) + 1;
    }
    if (cubes <= MOST_CUBES) {
      break;
    }
    grid->width *= 1.25;
  }
  for (int k = 0; k < 3; k++) {
    grid->least[k] = center[k] - radius;
    grid->counts[k] = (int)ceil(2 * radius / grid->width) + 1;
  }
  const size_t cubeCount = (size_t)grid->counts[0] * (size_t)grid->counts[1] * (size_t)grid->counts[2];
  grid->firsts = calloc(cubeCount + 1, sizeof *grid->firsts);
  int* ends = malloc((cubeCount + 1) * sizeof *ends);
  grid->items = NULL;
  if (grid->firsts == NULL || ends == NULL) {
    free(ends);
    return false;
  }
  enter(grid, count, spheres, reach, NULL);
  for (size_t i = 0; i < cubeCount; i++) {
    grid->firsts[i + 1] += grid->firsts[i];
    ends[i] = grid->firsts[i];
  }
  grid->items = malloc(((size_t)grid->firsts[cubeCount] + 1) * sizeof *grid->items);
  if (grid->items != NULL) {
    enter(grid, count, spheres, reach, ends);
  }
  free(ends);
  return grid->items != NULL && sortLists(grid, spheres);
}

void freeSphereGrid(SphereGrid* grid) {
  free(grid->firsts);
  free(grid->items);
}
