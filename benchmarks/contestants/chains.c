#include "chains.h"

#include <string.h>

#include "memory.h"

enum { LATTICE_SPACING = 4, BACKBITES_PER_SITE = 12 };

typedef struct Site {
  int x[3];
} Site;

/* The bonds at the two ends turn only spheres on their axes, so the links there are of two spheres. */
static Scene* chainOf(const Site* sites, int count) {
  Scene* scene = sceneAllocate(count, count - 2, 0);
  for (int i = 0; i < count; i++) {
    scene->spheres[i].radius = 1;
    for (int k = 0; k < 3; k++) {
      scene->spheres[i].x[k] = LATTICE_SPACING * sites[i].x[k];
    }
    scene->particleLinks[i] = i == 0 ? 0 : i == count - 1 ? count - 3 : i - 1;
    scene->particleNames[i] = i;
  }
  for (int link = 0; link < count - 2; link++) {
    scene->linkParents[link] = link - 1;
    if (link > 0) {
      scene->torsions[scene->torsionCount++] =
          (Torsion){.axis = {link, link + 1}, .first = link + 1, .last = count, .link = link};
    }
  }
  sceneIndexExclusions(scene);
  return scene;
}

/* ---- Serpentine ---- */

static int cubeSide(int count) {
  int side = 1;
  while ((long long)side * side * side < count) {
    side++;
  }
  return side;
}

static Site serpentineSite(int index, int side) {
  const int row = index / side;
  const int layer = row / side;
  const int x = index % side;
  const int y = row % side;
  return (Site){{row % 2 == 0 ? x : side - 1 - x, layer % 2 == 0 ? y : side - 1 - y, layer}};
}

static Site* serpentineSites(int count) {
  Site* sites = allocate(count, sizeof *sites);
  const int side = cubeSide(count);
  for (int i = 0; i < count; i++) {
    sites[i] = serpentineSite(i, side);
  }
  return sites;
}

Scene* chainSerpentine(int count) {
  Site* sites = serpentineSites(count);
  Scene* scene = chainOf(sites, count);
  free(sites);
  return scene;
}

/* ---- Hilbert ---- */

/* One level of the curve: where each eighth of a cube lies, in Gray code, and how the curve within it is turned, by
 * the axis that its own x, y and z become; a negative sign reverses it. */
static void hilbertOctant(int octant, int axes[3], int signs[3], int corner[3]) {
  static const int gray[8] = {0, 1, 3, 2, 6, 7, 5, 4};
  static const int turnedAxes[8][3] = {{1, 2, 0}, {2, 0, 1}, {2, 0, 1}, {0, 1, 2},
                                       {0, 1, 2}, {2, 0, 1}, {2, 0, 1}, {1, 2, 0}};
  static const int turnedSigns[8][3] = {{1, 1, 1},   {1, 1, 1},   {1, 1, 1},   {-1, -1, 1},
                                        {-1, -1, 1}, {-1, 1, -1}, {-1, 1, -1}, {1, -1, -1}};
  int newAxes[3];
  int newSigns[3];
  for (int k = 0; k < 3; k++) {
    const int bit = gray[octant] >> k & 1;
    corner[axes[k]] = signs[k] > 0 ? bit : 1 - bit;
    newAxes[k] = axes[turnedAxes[octant][k]];
    newSigns[k] = signs[turnedAxes[octant][k]] * turnedSigns[octant][k];
  }
  memcpy(axes, newAxes, sizeof newAxes);
  memcpy(signs, newSigns, sizeof newSigns);
}

static Site hilbertSite(int index, int levels) {
  int axes[3] = {0, 1, 2};
  int signs[3] = {1, 1, 1};
  Site site = {{0, 0, 0}};
  for (int level = levels - 1; level >= 0; level--) {
    int corner[3];
    hilbertOctant(index >> (3 * level) & 7, axes, signs, corner);
    for (int k = 0; k < 3; k++) {
      site.x[k] = 2 * site.x[k] + corner[k];
    }
  }
  return site;
}

Scene* chainHilbert(int count) {
  Site* sites = allocate(count, sizeof *sites);
  int levels = 0;
  while ((1LL << (3 * levels)) < count) {
    levels++;
  }
  for (int i = 0; i < count; i++) {
    sites[i] = hilbertSite(i, levels);
  }
  Scene* scene = chainOf(sites, count);
  free(sites);
  return scene;
}

/* ---- Random compact ---- */

/* A walk within a cube, and which of its places is at a site, or -1. */
typedef struct LatticeWalk {
  int side;
  int count;
  Site* sites;
  int* places;
} LatticeWalk;

static int* placeAt(const LatticeWalk* walk, const Site* site) {
  return &walk->places[(site->x[2] * walk->side + site->x[1]) * walk->side + site->x[0]];
}

static void put(LatticeWalk* walk, int place, Site site) {
  walk->sites[place] = site;
  *placeAt(walk, &site) = place;
}

static void reverse(LatticeWalk* walk, int first, int last) {
  for (; first < last; first++, last--) {
    const Site site = walk->sites[first];
    put(walk, first, walk->sites[last]);
    put(walk, last, site);
  }
}

static void backbite(LatticeWalk* walk, Random* random) {
  const bool atStart = randomInt(random, 2) == 0;
  const int direction = randomInt(random, 6);
  Site site = walk->sites[atStart ? 0 : walk->count - 1];
  site.x[direction / 2] += direction % 2 == 0 ? 1 : -1;
  if (site.x[direction / 2] < 0 || site.x[direction / 2] >= walk->side) {
    return;
  }
  const int place = *placeAt(walk, &site);
  if (place >= 0 && atStart) {
    reverse(walk, 0, place - 1);
  } else if (place >= 0) {
    reverse(walk, place + 1, walk->count - 1);
  } else {
    const int left = atStart ? walk->count - 1 : 0;
    *placeAt(walk, &walk->sites[left]) = -1;
    for (int k = 1; k < walk->count; k++) {
      const int to = atStart ? walk->count - k : k - 1;
      put(walk, to, walk->sites[atStart ? to - 1 : to + 1]);
    }
    put(walk, atStart ? 0 : walk->count - 1, site);
  }
}

Scene* chainRandom(int count, Random* random) {
  LatticeWalk walk = {.side = cubeSide(count), .count = count, .sites = serpentineSites(count)};
  const int cube = walk.side * walk.side * walk.side;
  walk.places = allocate(cube, sizeof(int));
  memset(walk.places, -1, (size_t)cube * sizeof(int));
  for (int i = 0; i < count; i++) {
    put(&walk, i, walk.sites[i]);
  }
  for (long long k = 0; k < (long long)BACKBITES_PER_SITE * count; k++) {
    backbite(&walk, random);
  }
  Scene* scene = chainOf(walk.sites, count);
  free(walk.sites);
  free(walk.places);
  return scene;
}
