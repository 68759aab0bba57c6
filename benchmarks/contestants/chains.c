#include "chains.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_COUNT = 4, LATTICE_SPACING = 4, BACKBITES_PER_SITE = 12 };

typedef struct Site {
  int x[3];
} Site;

/* The bonds at the two ends turn nothing off their axes, so the links there are of two spheres. */
static Scene* chainOf(const Site* sites, int count, double spacing, double radius) {
  SceneSource source;
  if (count < LEAST_COUNT || !sceneSourceInit(&source, count, count - 2, 0)) {
    return NULL;
  }
  for (int i = 0; i < count; i++) {
    source.spheres[i] = (Sphere){{spacing * sites[i].x[0], spacing * sites[i].x[1], spacing * sites[i].x[2]}, radius};
    source.particleLinks[i] = i == 0 ? 0 : i == count - 1 ? count - 3 : i - 1;
  }
  for (int link = 0; link < count - 2; link++) {
    source.links[link] = (SourceLink){.parent = link - 1, .axis = {link, link + 1}};
  }
  char error[128];
  Scene* scene = sceneMake(&source, error, sizeof error);
  sceneSourceFree(&source);
  return scene;
}

static Site* allocateSites(int count) {
  return count < LEAST_COUNT ? NULL : calloc((size_t)count, sizeof(Site));
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
  Site* sites = allocateSites(count);
  if (sites != NULL) {
    const int side = cubeSide(count);
    for (int i = 0; i < count; i++) {
      sites[i] = serpentineSite(i, side);
    }
  }
  return sites;
}

Scene* chainSerpentine(int count) {
  Site* sites = serpentineSites(count);
  Scene* scene = sites == NULL ? NULL : chainOf(sites, count, LATTICE_SPACING, 1);
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
  Site* sites = allocateSites(count);
  if (sites == NULL) {
    return NULL;
  }
  int levels = 0;
  while ((1LL << (3 * levels)) < count) {
    levels++;
  }
  for (int i = 0; i < count; i++) {
    sites[i] = hilbertSite(i, levels);
  }
  Scene* scene = chainOf(sites, count, LATTICE_SPACING, 1);
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
  const size_t cube = (size_t)walk.side * (size_t)walk.side * (size_t)walk.side;
  walk.places = malloc(cube * sizeof(int));
  Scene* scene = NULL;
  if (walk.sites != NULL && walk.places != NULL) {
    memset(walk.places, -1, cube * sizeof(int));
    for (int i = 0; i < count; i++) {
      put(&walk, i, walk.sites[i]);
    }
    for (long long k = 0; k < (long long)BACKBITES_PER_SITE * count; k++) {
      backbite(&walk, random);
    }
    scene = chainOf(walk.sites, count, LATTICE_SPACING, 1);
  }
  free(walk.sites);
  free(walk.places);
  return scene;
}

/* ---- Worst case ---- */

/* Three rows of d sites, one along each axis. */
static Site unitSite(int index, int d) {
  const int step = index % d;
  if (index < d) {
    return (Site){{step, 0, 0}};
  }
  return index < 2 * d ? (Site){{d - 1, 1 + step, 0}} : (Site){{d - 1, d, 1 + step}};
}

/* Layers of d/8 units side by side, each walked in the direction opposite to the one before it, and d/8 layers. */
Scene* chainWorstCase(int count) {
  int d = 0;
  while (3LL * (d + 8) * (d + 8) * (d + 8) / 64 <= count) {
    d += 8;
  }
  const int copies = d / 8;
  const int unit = 3 * d;
  const int layer = unit * copies;
  Site* sites = allocateSites(layer * copies);
  if (sites == NULL) {
    return NULL;
  }
  for (int i = 0; i < layer * copies; i++) {
    const int height = i / layer;
    const int inLayer = height % 2 == 0 ? i % layer : layer - 1 - i % layer;
    const int copy = inLayer / unit;
    const int inUnit = copy % 2 == 0 ? inLayer % unit : unit - 1 - inLayer % unit;
    const Site site = unitSite(inUnit, d);
    sites[i] = (Site){{site.x[0] + copy, site.x[1] - copy - height, site.x[2] + height}};
  }
  Scene* scene = chainOf(sites, layer * copies, 2, 0.999);
  free(sites);
  return scene;
}
