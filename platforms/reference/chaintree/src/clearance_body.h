/* Tests by clearances, compiled once for each instruction set by the file that includes this. */
#include "clearance.h"
#include "view_body.h"

/* Two pieces that move against each other. Leaves that they share with a neighbour belong to both. */
typedef struct Crossing {
  int beginA;
  int endA;
  int motionA;
  int beginB;
  int endB;
  int motionB;
  float back[12]; /* what takes A, at rest, to where B, at rest, sees it in the view */
} Crossing;

/* ---- How far bodies go ---- */

/* Puts all nodes into the world, so that all leaves have their spheres there. */
static void putNodesToRest(Traversal* t) {
  const Tree* tree = t->tree;
  for (int level = treeTop(tree); level > 0; level--) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      putToRest(t, level, tree->levelBegin[level] + i);
    }
  }
}

/* The spheres of sixteen leaves at rest. */
static const Block* leafSpheres(const Traversal* t, int block) {
  return &t->rest[t->restAt[t->tree->levelBegin[1]] + block];
}

static Sphere leafSphere(const Traversal* t, int leaf) {
  return sphereOf(leafSpheres(t, leaf / TREE_WIDTH), leaf % TREE_WIDTH);
}

/* Clearances of a leaf and those after it. */
static uint16_t* rowOf(const Clearance* c, int leaf) {
  return c->least + (size_t)leaf * (size_t)c->stride;
}

/* Turns lengths into units, rounded down. */
static void storeUnits(const Clearance* c, Float16 lengths, uint16_t* units) {
  float values[TREE_WIDTH];
  const Float16 most = all16((float)MOST_CLEARANCE);
  store16(values, min16(max16(mul16(lengths, all16(0.999999f / c->unit)), all16(0)), most));
  for (int k = 0; k < TREE_WIDTH; k++) {
    units[k] = (uint16_t)(int)values[k];
  }
}

/* Bounds how far a rigid motion takes the particles of these leaves, in units, rounded up. */
static void boundShifts(Clearance* c, const Traversal* t, const Frame* motion, int begin, int end) {
  /* What the motion adds to a point: small where it is small. */
  float change[12];
  double trace = 0;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 4; j++) {
      change[4 * i + j] = (float)(motion->m[i][j] - (i == j));
    }
    trace += motion->m[i][i];
  }
  /* |R - 1|, with room for the rounding of the trace, and room for that of the centres. */
  const double chord = sqrt(larger(0, 3 - trace) + 1e-13);
  const Float16 room = all16((float)(FLOAT_MARGIN * chord * t->extent + 2 * (double)c->unit));
  for (int block = begin / TREE_WIDTH; block <= (end - 1) / TREE_WIDTH; block++) {
    const Block* spheres = leafSpheres(t, block);
    const Float16 x = moved16(spheres, change);
    const Float16 y = moved16(spheres, change + 4);
    const Float16 z = moved16(spheres, change + 8);
    const Float16 centre = sqrt16(squared16(x, y, z));
    const Float16 turned = mul16(max16(load16(spheres->r), all16(0)), all16((float)chord));
    storeUnits(c, mul16(add16(add16(centre, turned), room), all16(1.00001f)), c->shift + TREE_WIDTH * block);
  }
}

/* Calls `visit` for each two pieces of the view that move against each other, their shifts bounded; ends with true as
 * soon as that does. Adds what the bounds cost. */
typedef bool CrossingFunction(Clearance* c, Traversal* t, const Crossing* crossing, void* context);

static bool forEachCrossing(Clearance* c, Traversal* t, CrossingFunction* visit, void* context, int64_t* cost) {
  const View* view = t->view;
  for (int p = 0; p < view->pieceCount; p++) {
    for (int q = p + 1; q < view->pieceCount; q++) {
      if (view->pieces[p].motion == view->pieces[q].motion) {
        continue;
      }
      const int endOfQ = q + 1 < view->pieceCount ? view->pieces[q + 1].slotBegin : t->tree->slotCount;
      Crossing crossing = {view->pieces[p].slotBegin / TREE_WIDTH,
                           (view->pieces[p + 1].slotBegin - 1) / TREE_WIDTH + 1,
                           view->pieces[p].motion,
                           view->pieces[q].slotBegin / TREE_WIDTH,
                           (endOfQ - 1) / TREE_WIDTH + 1,
                           view->pieces[q].motion,
                           {0}};
      const Frame back = transformInverse(&view->motions[crossing.motionA]);
      const Frame between = transformCompose(&back, &view->motions[crossing.motionB]);
      const Frame other = transformInverse(&between);
      floatMotion(&other, crossing.back);
      /* A distance changes by no more than either of its ends is displaced. */
      boundShifts(c, t, &between, crossing.beginA, crossing.endA);
      boundShifts(c, t, &between, crossing.beginB, crossing.endB);
      *cost += 200 + (crossing.endA - crossing.beginA + crossing.endB - crossing.beginB) / 2;
      if (visit(c, t, &crossing, context)) {
        return true;
      }
    }
  }
  return false;
}

/* The columns of a row that a crossing has, in [begin, end): mask of them from column `first` on. */
static uint32_t columnsWithin(int first, int begin, int end) {
  uint32_t mask = ~(uint32_t)0;
  if (first < begin) {
    mask <<= begin - first;
  }
  if (end - first < COLUMNS_AT_ONCE) {
    mask &= ((uint32_t)1 << (end - first)) - 1;
  }
  return mask;
}

/* ---- Measuring ---- */

static void measureClearances(Clearance* c, Traversal* t, double reach) {
  const View view = ctViewOfState(true, reach);
  startView(t, &view);
  putNodesToRest(t);
  float widest = 0;
  for (int leaf = 0; leaf < c->leafCount; leaf++) {
    const float r = leafSphere(t, leaf).r;
    widest = r > widest ? r : widest;
  }
  c->unit = 4 * widest / (float)MOST_CLEARANCE;
  const Float16 room = all16((float)(reach + floatMargin(t->extent + fabs(reach))));
  for (int a = 0; a < c->leafCount; a++) {
    const Sphere own = leafSphere(t, a);
    for (int block = a / TREE_WIDTH; block <= (c->leafCount - 1) / TREE_WIDTH; block++) {
      const Block* spheres = leafSpheres(t, block);
      const Float16 distance = sqrt16(squaredFrom(spheres, own.x, own.y, own.z));
      const Float16 radii = max16(add16(load16(spheres->r), all16(own.r)), all16(0));
      storeUnits(c, sub16(sub16(distance, radii), room), rowOf(c, a) + TREE_WIDTH * block);
    }
  }
}

/* ---- Testing ---- */

typedef struct ClearanceTest {
  ClearanceFunction* function;
  void* context;
  float room; /* reach and the rounding of distances */
  bool clash;
  int64_t cost;
  int64_t volumeTests;
  int64_t particleTests;
} ClearanceTest;

/* The members of a leaf, made ready once to be compared with those of another. */
typedef struct Partners {
  Float16 x; /* INFINITY: no member */
  Float16 y;
  Float16 z;
  Float16 r;
  float widest;
} Partners;

static Partners partnersOf(const Block* block) {
  const Float16 radii = load16(block->r);
  const unsigned empty = greater16(all16(0), radii);
  return (Partners){blend16(empty, load16(block->x), all16(INFINITY)), load16(block->y), load16(block->z),
                    blend16(empty, radii, all16(0)), most16(radii)};
}

/* Squared distances from a member less those at which the two would meet: a root for each would cost more than all
 * else.
 */
CT_INLINE Float16 beyondMeeting(const Partners* partners, const Block* block, int k, float room) {
  const Float16 squared = squared16(sub16(partners->x, all16(block->x[k])), sub16(partners->y, all16(block->y[k])),
                                    sub16(partners->z, all16(block->z[k])));
  const float reach = block->r[k] + room;
  const Float16 meet = add16(partners->r, all16(reach > 0 ? reach : 0));
  return sub16(squared, mul16(meet, meet));
}

/* The least clearance of pairs of which this is the least of those squares. */
static float clearanceBeyond(float square, float widest) {
  /* d - s = (d^2 - s^2) / (d + s), the less the larger s is. */
  const float meet = widest > 0 ? widest : 0;
  return square > 0 && square < INFINITY ? square / (sqrtf(square + meet * meet) + meet) : square;
}

/* The least clearance of two leaves of which all pairs count; below 0: some may overlap. */
static float clearanceOfFar(const Block* blockA, const Block* blockB, float room) {
  const Partners partners = partnersOf(blockB);
  Float16 least = all16(INFINITY);
  float widest = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    if (blockA->r[k] >= 0) {
      least = min16(least, beyondMeeting(&partners, blockA, k, room));
      widest = blockA->r[k] > widest ? blockA->r[k] : widest;
    }
  }
  return clearanceBeyond(least16(least), partners.widest + widest + room);
}

/* The least clearance of the particles of two expanded leaves, or of one with itself, in the view; INFINITY: they have
 * no pair that counts. */
static float leafClearance(Traversal* t, ClearanceTest* test, int a, int b) {
  const Block* blocks[2];
  blocksOf(t, a, b, blocks);
  const Block* blockA = blocks[0];
  const int partner = exclusionPartner(t->exclusions, a, b);
  test->particleTests += TREE_WIDTH * TREE_WIDTH;
  if (a != b && partner == CT_NULL) {
    const float clearance = clearanceOfFar(blockA, blocks[1], test->room);
    if (clearance >= 0) {
      return clearance;
    }
  }
  const Partners partners = partnersOf(blocks[1]);
  Float16 least16s = all16(INFINITY);
  float least = INFINITY;
  float widest = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    if (blockA->r[k] < 0) {
      continue;
    }
    unsigned out = a == b ? (2u << k) - 1 : 0;
    if (partner != CT_NULL) {
      out |= t->exclusions->mask[partner][k];
    }
    const Float16 beyond = beyondMeeting(&partners, blockA, k, test->room);
    const unsigned close = greater16(all16(0), beyond) & ~out;
    least16s = min16(least16s, blend16((out | close) & 0xffff, beyond, all16(INFINITY)));
    widest = blockA->r[k] > widest ? blockA->r[k] : widest;
    for (unsigned mask = close; mask != 0; mask &= mask - 1) {
      const int l = __builtin_ctz(mask);
      const int i = a * TREE_WIDTH + k;
      const int j = b * TREE_WIDTH + l;
      const bool crosses = motionOfMember(t, a, k) != motionOfMember(t, b, l);
      const double exact = test->function(test->context, i, j, ctTraversalSquaredDistance(t, i, j), crosses);
      if (crosses && exact < 0) {
        test->clash = true;
        return 0;
      }
      least = exact < (double)least ? (float)(exact - t->band) : least;
    }
  }
  const float far = clearanceBeyond(least16(least16s), partners.widest + widest + test->room);
  return far < least ? far : least;
}

static void expandLeaf(Traversal* t, int leaf, int motion) {
  if (t->itemStamp[leaf] != t->stamp) {
    t->motion[leaf] = motion;
    expand(t, 0, leaf);
  }
}

/* How much clearance the trial may use up: a distance changes by no more than either of its ends is displaced. */
static uint16_t boundOfPair(const Clearance* c, int a, int b) {
  return c->shift[a] < c->shift[b] ? c->shift[a] : c->shift[b];
}

/* What a test has found of a pair: how much clearance it has in the trial, in units. */
static void keepFound(Clearance* c, int a, int b, uint16_t bound, uint16_t found, bool isOfState) {
  if (isOfState) {
    const uint16_t before = found > bound ? (uint16_t)(found - bound) : 0;
    uint16_t* least = rowOf(c, a) + b;
    *least = before > *least ? before : *least;
  }
  /* Without memory for it, a commit just takes off the bound. */
  if (c->testedCount < c->testedCapacity) {
    c->tested[c->testedCount++] = (TestedPair){a, b, found};
  }
}

static bool isStraddler(const Traversal* t, int leaf) {
  return t->itemStamp[leaf] == t->stamp && t->motion[leaf] < 0;
}

/* A pair whose spheres are too near to tell. */
static void testPair(Clearance* c, Traversal* t, ClearanceTest* test, const Crossing* crossing, int a, int b) {
  const uint16_t bound = boundOfPair(c, a, b);
  expandLeaf(t, a, crossing->motionA);
  expandLeaf(t, b, crossing->motionB);
  const float clearance = leafClearance(t, test, a, b);
  test->cost += 60;
  if (!test->clash) {
    const float units = 0.999999f * clearance / c->unit;
    const float most = (float)MOST_CLEARANCE;
    /* Of lengths beyond those of a float nothing is known: no clearance. */
    const float kept = units > 0 ? units : 0;
    const uint16_t found = (uint16_t)(int)(kept < most ? kept : most);
    /* Of pieces that meet in a leaf, another than these may come nearer by more than this bound. */
    const bool isOfState = t->view->motionCount == 2 || !(isStraddler(t, a) || isStraddler(t, b));
    keepFound(c, a, b, bound, found, isOfState);
  }
}

/* Those of these sixteen leaves whose spheres leave that of leaf a, where they see it, more clearance than the bound.
 */
static unsigned testSpheres(Clearance* c, const Traversal* t, ClearanceTest* test, Sphere sphere, int a, int first,
                            unsigned columns) {
  for (int i = 0; i < t->straddlerCount; i++) {
    const int column = t->straddlers[i].item - first;
    if (column >= 0 && column < TREE_WIDTH) {
      columns &= ~(1u << column);
    }
  }
  const int count = __builtin_popcount(columns);
  test->volumeTests += count;
  test->cost += 6 * count;
  const Block* spheres = leafSpheres(t, first / TREE_WIDTH);
  const Float16 distance = sqrt16(squaredFrom(spheres, sphere.x, sphere.y, sphere.z));
  const Float16 radii = max16(add16(load16(spheres->r), all16(sphere.r + test->room)), all16(0));
  uint16_t units[TREE_WIDTH];
  storeUnits(c, sub16(distance, radii), units);
  unsigned safe = 0;
  for (; columns != 0; columns &= columns - 1) {
    const int k = __builtin_ctz(columns);
    const int b = first + k;
    const uint16_t bound = boundOfPair(c, a, b);
    if (units[k] > bound) {
      keepFound(c, a, b, bound, units[k], true);
      safe |= 1u << k;
    }
  }
  return safe;
}

/* Pairs whose clearance the bound may use up: leaf a with those from `first` on whose bit is set. True if nothing more
 * is to be tested. A function of its own, so that the search for them has all registers. */
static __attribute__((noinline)) bool testPairs(Clearance* c, Traversal* t, ClearanceTest* test,
                                                const Crossing* crossing, int a, int first, uint32_t columns) {
  ctReserve((void**)&c->tested, &c->testedCapacity, c->testedCount + COLUMNS_AT_ONCE, sizeof(TestedPair));
  if (!isStraddler(t, a)) {
    const Sphere sphere = movedSphere(leafSphere(t, a), crossing->back);
    for (int k = 0; k < COLUMNS_AT_ONCE; k += TREE_WIDTH) {
      const unsigned half = columns >> k & 0xffff;
      if (half != 0) {
        columns &= ~((uint32_t)testSpheres(c, t, test, sphere, a, first + k, half) << k);
      }
    }
  }
  for (; columns != 0; columns &= columns - 1) {
    testPair(c, t, test, crossing, a, first + __builtin_ctz(columns));
    if (test->clash || test->cost > c->mostCost) {
      return true;
    }
  }
  return false;
}

static bool testCrossing(Clearance* c, Traversal* t, const Crossing* crossing, void* context) {
  ClearanceTest* test = context;
  for (int a = crossing->beginA; a < crossing->endA; a++) {
    const int begin = crossing->beginB > a ? crossing->beginB : a + 1;
    const uint16_t* row = rowOf(c, a);
    const uint16_t own = c->shift[a];
    for (int first = begin / COLUMNS_AT_ONCE * COLUMNS_AT_ONCE; first < crossing->endB; first += COLUMNS_AT_ONCE) {
      uint32_t mask = within32(row + first, c->shift + first, own);
      if (mask == 0) {
        continue;
      }
      mask &= columnsWithin(first, begin, crossing->endB);
      if (mask != 0 && testPairs(c, t, test, crossing, a, first, mask)) {
        return true;
      }
    }
    test->cost += (crossing->endB - begin) / TREE_WIDTH;
  }
  return false;
}

/* Leaves in which pieces meet. */
static void expandStraddlingLeaves(Traversal* t) {
  const View* view = t->view;
  for (int p = 1; p < view->pieceCount; p++) {
    const int leaf = view->pieces[p].slotBegin / TREE_WIDTH;
    if (view->pieces[p].slotBegin % TREE_WIDTH != 0 && t->itemStamp[leaf] != t->stamp) {
      expandStraddler(t, 0, leaf, p - 1);
    }
  }
}

/* The same against themselves. */
static bool testStraddlingLeaves(Traversal* t, ClearanceTest* test) {
  for (int i = 0; i < t->straddlerCount && !test->clash; i++) {
    leafClearance(t, test, t->straddlers[i].item, t->straddlers[i].item);
  }
  return test->clash;
}

static int64_t testByClearance(Clearance* c, Traversal* t, const View* view, ClearanceFunction* function, void* context,
                               ctCounts* counts) {
  startView(t, view);
  putNodesToRest(t);
  expandStraddlingLeaves(t);
  ClearanceTest test = {function, context, (float)(view->reach + floatMargin(t->extent + fabs(view->reach))), false, 0,
                        0,        0};
  c->testedCount = 0;
  if (!testStraddlingLeaves(t, &test)) {
    forEachCrossing(c, t, testCrossing, &test, &test.cost);
  }
  if (counts != NULL) {
    counts->volumeTests += test.volumeTests;
    counts->particleTests += test.particleTests;
  }
  const bool gaveUp = !test.clash && test.cost > c->mostCost;
  return gaveUp ? GAVE_UP : 300 + c->leafCount / 2 + test.cost;
}

/* ---- Committing ---- */

static bool takeOff(Clearance* c, Traversal* t, const Crossing* crossing, void* context) {
  (void)t;
  int64_t* cost = context;
  for (int a = crossing->beginA; a < crossing->endA; a++) {
    const int begin = crossing->beginB > a ? crossing->beginB : a + 1;
    uint16_t* row = rowOf(c, a);
    const Short16 own = allShorts(c->shift[a]);
    for (int first = begin / TREE_WIDTH * TREE_WIDTH; first < crossing->endB; first += TREE_WIDTH) {
      const Short16 before = loadShorts(row + first);
      const Short16 after = lessShorts(before, minShorts(own, loadShorts(c->shift + first)));
      storeShorts(row + first, blendShorts(columnsWithin(first, begin, crossing->endB) & 0xffff, before, after));
    }
    *cost += (crossing->endB - begin) / TREE_WIDTH;
  }
  return false;
}

static int64_t commitClearances(Clearance* c, Traversal* t, const View* view) {
  int64_t cost = c->leafCount;
  startView(t, view);
  putNodesToRest(t);
  forEachCrossing(c, t, takeOff, &cost, &cost);
  for (int i = 0; i < c->testedCount; i++) {
    const TestedPair* pair = &c->tested[i];
    rowOf(c, pair->a)[pair->b] = pair->clearance;
  }
  c->testedCount = 0;
  return cost;
}
