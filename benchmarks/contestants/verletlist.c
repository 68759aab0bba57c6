/* Neighbour lists after Verlet (1967), for trials that turn torsions. A particle's list holds the others whose places
 * are within the sum of radii and a skin of its own. A place is where a particle was when its list was made; nobody
 * goes farther than half a skin from it without getting another.
 *
 * A torsion moves what lies far from its axis a long way. So in a trial particles that move by less than half a skin
 * look at their lists, and the others search a cell grid of the places. If the trial is taken over, only what went too
 * far gets new places: particle by particle, with new lists; or, if that is most of a piece, the whole piece at once,
 * whose lists of its own particles still hold. */
#include "batchsearch.h"
#include "lazy.h"

enum { ENTRIES_PER_PARTICLE = 8, FIRST_STRIDE = 16 };

/* The skin, as a part of the largest sum of two radii: from 0.25 to 0.5, local moves of proteins take the same time. */
#define SKIN 0.3

/* Half of it, but for what is rounded. */
#define HALF (0.5 * (1 - 1e-9))

typedef struct VerletList {
  Lazy lazy;
  Cells cells;    /* of places */
  int* entries;   /* the cell of each particle's place */
  Sphere* places; /* where each particle was when its list was made */
  double skin;
  int stride;      /* entries that there is room for in each list */
  int* listCounts; /* of each particle */
  int* lists;      /* neither the particle's own link nor excluded particles are in its list */
  /* While a trial is taken over: */
  bool isNew[MOST_TURNS + 2]; /* by body + 1, whether all of it gets new places at once */
  int outCount;               /* other particles too far from their places */
  int* out;
  Search search;
} VerletList;

static void destroy(void* self) {
  VerletList* verlet = self;
  cellsFree(&verlet->cells);
  free(verlet->entries);
  free(verlet->places);
  free(verlet->listCounts);
  free(verlet->lists);
  free(verlet->out);
  lazyDestroy(verlet);
}

/* ---- Lists ---- */

/* Twice as much room in each list. */
static void widenLists(VerletList* verlet) {
  const int count = verlet->lazy.keeper.scene->particleCount;
  const int stride = 2 * verlet->stride;
  int* lists = reallocate(verlet->lists, count, (size_t)stride * sizeof(int));
  for (int i = count - 1; i >= 0; i--) {
    memmove(lists + (size_t)i * (size_t)stride, lists + (size_t)i * (size_t)verlet->stride,
            (size_t)verlet->listCounts[i] * sizeof(int));
  }
  verlet->lists = lists;
  verlet->stride = stride;
}

static int* listOf(const VerletList* verlet, int i) {
  return verlet->lists + (size_t)i * (size_t)verlet->stride;
}

static void addToList(VerletList* verlet, int i, int j) {
  if (verlet->listCounts[i] == verlet->stride) {
    widenLists(verlet);
  }
  listOf(verlet, i)[verlet->listCounts[i]++] = j;
}

static void takeFromList(VerletList* verlet, int i, int j) {
  int* list = listOf(verlet, i);
  int k = 0;
  while (list[k] != j) {
    k++;
  }
  list[k] = list[--verlet->listCounts[i]];
}

/* Takes a particle out of all lists and the grid. */
static void takeOut(VerletList* verlet, int i) {
  const int* list = listOf(verlet, i);
  for (int k = 0; k < verlet->listCounts[i]; k++) {
    takeFromList(verlet, list[k], i);
  }
  verlet->listCounts[i] = 0;
  cellsRemove(&verlet->cells, verlet->entries[i], i);
}

/* Whose places make pairs with a search's. */
typedef struct Partners {
  VerletList* verlet;
  bool areOfOtherBodies; /* all of them, or only particles outside `body` */
  unsigned char body;
} Partners;

static int isPartner(const void* context, int j) {
  const Partners* partners = context;
  return !partners->areOfOtherBodies || partners->verlet->lazy.bodies[j] != partners->body;
}

/* Of two pieces with new places, the later finds the pair. */
static bool listPair(void* context, int i, int j) {
  Partners* partners = context;
  VerletList* verlet = partners->verlet;
  const Scene* scene = verlet->lazy.keeper.scene;
  const bool isForOther = partners->areOfOtherBodies && verlet->isNew[verlet->lazy.bodies[j]] && j > i;
  if (!isForOther && scene->particleLinks[i] != scene->particleLinks[j] && !sceneExcludes(scene, i, j)) {
    addToList(verlet, i, j);
    addToList(verlet, j, i);
  }
  return false;
}

/* Lists the pairs of the particles that search. */
static void listPairs(VerletList* verlet, bool ofOtherBodies, unsigned char body) {
  Partners partners = {verlet, ofOtherBodies, body};
  searchFind(&verlet->search, &verlet->cells, verlet->places, verlet->skin, isPartner, listPair, &partners,
             &verlet->lazy.keeper.counts.particleTests);
}

/* Puts a particle's place into the grid. */
static void setPlace(VerletList* verlet, int i, const Sphere* sphere) {
  verlet->places[i] = *sphere;
  verlet->entries[i] = cellOf(&verlet->cells, sphere);
  cellsInsert(&verlet->cells, verlet->entries[i], i);
}

/* Gives a particle a place among those in the grid, and adds it to their lists. */
static void putIn(VerletList* verlet, int i, const Sphere* sphere) {
  searchAdd(&verlet->search, &verlet->cells, i, sphere);
  listPairs(verlet, false, 0);
  setPlace(verlet, i, sphere);
}

static void* make(const Scene* scene) {
  VerletList* verlet = lazyMake(scene, sizeof *verlet);
  const int count = scene->particleCount;
  verlet->skin = SKIN * cellsReach(scene);
  verlet->stride = FIRST_STRIDE;
  verlet->entries = allocate(count, sizeof(int));
  verlet->places = allocate(count, sizeof(Sphere));
  verlet->listCounts = allocate(count, sizeof(int));
  verlet->lists = allocate(count, FIRST_STRIDE * sizeof(int));
  verlet->out = allocate(count, sizeof(int));
  cellsInit(&verlet->cells, scene, cellsReach(scene) + verlet->skin, ENTRIES_PER_PARTICLE, 1);
  for (int i = 0; i < count; i++) {
    putIn(verlet, i, &scene->spheres[i]);
  }
  verlet->lazy.keeper.counts = (Counts){0};
  return verlet;
}

/* ---- Test ---- */

static bool isOut(const VerletList* verlet, int i, const Sphere* sphere) {
  const double most = HALF * verlet->skin;
  return squaredDistance(sphere->x, verlet->places[i].x) > most * most;
}

static bool listMeets(VerletList* verlet, const Run* run, int i) {
  Keeper* keeper = &verlet->lazy.keeper;
  const Sphere* sphere = &run->moved[i];
  const int* list = listOf(verlet, i);
  for (int k = 0; k < verlet->listCounts[i]; k++) {
    const int j = list[k];
    if (verlet->lazy.bodies[j] == run->body) {
      const double sum = sphere->radius + keeper->spheres[j].radius;
      keeper->counts.particleTests++;
      if (squaredDistance(sphere->x, keeper->spheres[j].x) < sum * sum) {
        return true;
      }
    }
  }
  return false;
}

/* Particles that are not too far away look at their lists at once; the others search together. */
static bool runMeets(Lazy* lazy, const Run* run) {
  VerletList* verlet = (VerletList*)lazy;
  Keeper* keeper = &lazy->keeper;
  Others others = lazyOthers(lazy, run);
  bool meets = false;
  for (int i = run->first; i < run->last && !meets; i++) {
    run->moved[i] = movedSphere(run->motion, &keeper->spheres[i]);
    if (isOut(verlet, i, &run->moved[i])) {
      searchAdd(&verlet->search, &verlet->cells, i, &run->moved[i]);
    } else {
      meets = listMeets(verlet, run, i);
    }
  }
  if (meets) {
    searchEnd(&verlet->search);
    return true;
  }
  return searchFind(&verlet->search, &verlet->cells, keeper->spheres, 0, isOther, otherIsClash, &others,
                    &keeper->counts.particleTests);
}

static bool test(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeets);
}

/* ---- After the test ---- */

/* Moves the places of a segment with it. Pairs with other bodies are listed no more. */
static void movePlaces(VerletList* verlet, const Segment* segment) {
  const unsigned char* bodies = verlet->lazy.bodies;
  const Rigid* motion = &verlet->lazy.motion.motions[segment->body];
  for (int i = segment->first; i < segment->last; i++) {
    int* list = listOf(verlet, i);
    for (int k = verlet->listCounts[i] - 1; k >= 0; k--) {
      if (bodies[list[k]] != bodies[i]) {
        takeFromList(verlet, list[k], i);
        list[k] = list[--verlet->listCounts[i]];
      }
    }
    const Sphere place = movedSphere(motion, &verlet->places[i]);
    cellsRemove(&verlet->cells, verlet->entries[i], i);
    setPlace(verlet, i, &place);
  }
}

/* Which bodies go most of them too far. */
static void findNew(VerletList* verlet) {
  const Lazy* lazy = &verlet->lazy;
  int outCounts[MOST_TURNS + 1] = {0};
  for (int s = 0; s < lazy->motion.segmentCount; s++) {
    const Segment* segment = &lazy->motion.segments[s];
    for (int i = segment->first; i < segment->last && segment->body != lazy->motion.resting; i++) {
      outCounts[segment->body] += isOut(verlet, i, &lazy->keeper.trial[i]);
    }
  }
  verlet->isNew[0] = false;
  for (int body = 0; body < lazy->motion.bodyCount; body++) {
    verlet->isNew[body + 1] = 2 * outCounts[body] > lazy->motion.sizes[body];
  }
}

/* Particles that move too far leave the lists one by one. */
static void takeOutSome(VerletList* verlet, const Segment* segment) {
  const Keeper* keeper = &verlet->lazy.keeper;
  for (int i = segment->first; i < segment->last; i++) {
    if (isOut(verlet, i, &keeper->spheres[i])) {
      takeOut(verlet, i);
      verlet->out[verlet->outCount++] = i;
    }
  }
}

/* Everything leaves its lists before anything enters others, so that nobody is listed by a place that is given up. */
static void changePlaces(VerletList* verlet) {
  const Bodies* motion = &verlet->lazy.motion;
  findNew(verlet);
  verlet->outCount = 0;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting && !verlet->isNew[segment->body + 1]) {
      takeOutSome(verlet, segment);
    }
  }
  for (int s = 0; s < motion->segmentCount; s++) {
    if (verlet->isNew[motion->segments[s].body + 1]) {
      movePlaces(verlet, &motion->segments[s]);
    }
  }
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    for (int i = segment->first; i < segment->last && verlet->isNew[segment->body + 1]; i++) {
      searchAdd(&verlet->search, &verlet->cells, i, &verlet->places[i]);
      if (verlet->search.count == SEARCHERS || i + 1 == segment->last) {
        listPairs(verlet, true, (unsigned char)(segment->body + 1));
      }
    }
  }
  for (int k = 0; k < verlet->outCount; k++) {
    putIn(verlet, verlet->out[k], &verlet->lazy.keeper.spheres[verlet->out[k]]);
  }
}

static void accept(void* self) {
  VerletList* verlet = self;
  Keeper* keeper = &verlet->lazy.keeper;
  const Bodies* motion = &verlet->lazy.motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting) {
      memcpy(keeper->spheres + segment->first, keeper->trial + segment->first,
             (size_t)(segment->last - segment->first) * sizeof(Sphere));
    }
  }
  lazyMarkBodies(&verlet->lazy, true);
  changePlaces(verlet);
  lazyMarkBodies(&verlet->lazy, false);
}

const Contestant CONTESTANT(contestantVerletList) = {
    .name = "verletlist",
    .idea = "lists of neighbours with a skin, and a grid for what goes far",
    .make = make,
    .destroy = destroy,
    .test = test,
    .accept = accept,
    .reject = keeperReject,
    .counts = keeperCounts,
    .spheres = keeperSpheres};
