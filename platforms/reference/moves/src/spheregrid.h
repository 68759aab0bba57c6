/* Fixed spheres by place, for tests of single spheres against them. */
#ifndef CT_SPHEREGRID_H_
#define CT_SPHEREGRID_H_

#include <stdbool.h>
#include <stdint.h>

/* A sphere: its center and radius. */
typedef struct Sphere {
  double x[3];
  double radius;
} Sphere;

/* A grid of cubes, each with all spheres that a sphere with its center in the cube may touch. */
typedef struct SphereGrid {
  double least[3]; /* nm, the corner of the first cube */
  double width;    /* nm, of a cube */
  int counts[3];
  int* firsts; /* where the spheres of each cube begin in `items` */
  int* items;
} SphereGrid;

/* Makes a grid of the spheres near a ball. reach: the largest radius of a sphere to be tested, less what it may
 * overlap. False if there is no memory. */
bool makeSphereGrid(int count, const Sphere* spheres, const double center[3], double radius, double reach,
                    SphereGrid* grid);

void freeSphereGrid(SphereGrid* grid);

/* The spheres that may touch one at x: their number. */
static inline int spheresNear(const SphereGrid* grid, const double x[3], const int** items) {
  int cube = 0;
  for (int k = 0; k < 3; k++) {
    const double place = (x[k] - grid->least[k]) / grid->width;
    if (!(place >= 0 && place < grid->counts[k])) {
      return 0;
    }
    cube = cube * grid->counts[k] + (int)place;
  }
  *items = grid->items + grid->firsts[cube];
  return grid->firsts[cube + 1] - grid->firsts[cube];
}

#endif /* CT_SPHEREGRID_H_ */
