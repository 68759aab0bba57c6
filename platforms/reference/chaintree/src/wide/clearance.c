/* Tests by clearances. */
#include "leafruns.h"

/* ---- The table ---- */

/* The clearances of a leaf with the leaves after it. */
static uint16_t* rowOf(const Clearance* c, int leaf) {
  return c->least + (size_t)leaf * (size_t)c->stride;
}

/* Bit k: column first + k is in [begin, end). */
static uint32_t columnsWithin(int first, int begin, int end) {
  const int before = begin < first ? 0 : begin - first < COLUMNS_AT_ONCE ? begin - first : COLUMNS_AT_ONCE;
  const int upTo = end < first ? 0 : end - first < COLUMNS_AT_ONCE ? end - first : COLUMNS_AT_ONCE;
  const uint64_t one = 1;
  return (uint32_t)(((one << upTo) - 1) & ~((one << before) - 1));
}

/* The first column of row a that belongs to a pair of runs. */
static int columnsBegin(const RunPair* pair, int a) {
  return pair->beginB > a ? pair->beginB : a + 1;
}

/* ---- Measuring ---- */

/* Updates the world coordinates of all inner nodes: these hold the spheres of all leaves. */
static void updateWorldNodes(Traversal* t) {
  const Tree* tree = t->tree;
  for (int level = treeTop(tree); level > 0; level--) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      updateWorld(t->world, level, tree->levelBegin[level] + i);
    }
  }
}

void CT_WIDE(measureClearances)(Clearance* c, Traversal* t, double reach) {
  const View view = ctViewOfState(reach);
  CT_WIDE(startView)(t, &view);
  updateWorldNodes(t);
  float widest = 0;
  for (int leaf = 0; leaf < c->leafCount; leaf++) {
    const float r = leafSphere(t, leaf).r;
    widest = r > widest ? r : widest;
  }
  c->unit = 4 * widest / (float)MOST_CLEARANCE;
  const Float16 nearest = all16((float)(reach + floatMargin(t->coordinateBound + fabs(reach))));
  for (int a = 0; a < c->leafCount; a++) {
    const Sphere own = leafSphere(t, a);
    for (int block = coveringNode(a); block <= coveringNode(c->leafCount - 1); block++) {
      const Block* spheres = leafSpheres(t, block);
      const Float16 distance = sqrt16(squaredFrom(spheres, own.x, own.y, own.z));
      const Float16 radii = max16(add16(load16(spheres->r), all16(own.r)), all16(0));
      storeShorts(rowOf(c, a) + TREE_WIDTH * block, unitsOf(c, sub16(sub16(distance, radii), nearest)));
    }
  }
}

/* ---- Testing ---- */

typedef struct ClearanceTest {
  ClearanceFunction* function;
  void* context;
  float reach; /* of the view, and FLOAT_MARGIN */
  bool clash;
  bool outOfMemory;
  int64_t cost;
  int64_t volumeTests;
  int64_t particleTests;
} ClearanceTest;

/* The members of a leaf, prepared for the comparison with those of another. */
typedef struct Partners {
  Float16 x; /* INFINITY: no member */
  Float16 y;
  Float16 z;
  Float16 reach; /* their radii and the test's reach */
  float widest;  /* the largest of those */
} Partners;

static Partners partnersOf(const Block* block, float reach) {
  const Float16 radii = load16(block->r);
  const unsigned empty = greater16(all16(0), radii);
  return (Partners){blend16(empty, load16(block->x), all16(INFINITY)), load16(block->y), load16(block->z),
                    blend16(empty, add16(radii, all16(reach)), all16(0)), most16(radii) + reach};
}

/* Squared distances of a member less the squares of the distances at which the two would clash. A root for each pair
 * would cost more than everything else. */
CT_INLINE Float16 beyondMeeting(const Partners* partners, const Block* block, int k) {
  const Float16 squared = squared16(sub16(partners->x, all16(block->x[k])), sub16(partners->y, all16(block->y[k])),
                                    sub16(partners->z, all16(block->z[k])));
  const Float16 meet = max16(add16(partners->reach, all16(block->r[k])), all16(0));
  return sub16(squared, mul16(meet, meet));
}

/* A lower bound of the clearance of pairs of which the least of those differences is this; no pair clashes from farther
 * away than `widest`.
 *
 * The clearance d - s = (d^2 - s^2) / (d + s) is the less the larger s is. Its error: positions, up to 8 u E for either
 * particle (u = 2^-24, E: the view's coordinate bound), of which d is off by 16 u E; the two squares, 5 u of each,
 * which is 10 u E of the difference of their roots; root, sum and quotient, 5 u of no more than 2 E. Together 36 u E,
 * of the 67 u E of FLOAT_MARGIN in the test's reach. */
static float clearanceBeyond(float square, float widest) {
  const float meet = widest > 0 ? widest : 0;
  return square > 0 && square < INFINITY ? square / (sqrtf(square + meet * meet) + meet) : square;
}

/* A lower bound of the clearance of two leaves without excluded pairs, the first without empty slots; below 0: some
 * pairs may clash. */
static float clearanceOfFar(const Block* blockA, const Block* blockB, float reach) {
  const Partners partners = partnersOf(blockB, reach);
  Float16 least = all16(INFINITY);
  for (int k = 0; k < TREE_WIDTH; k++) {
    least = min16(least, beyondMeeting(&partners, blockA, k));
  }
  return clearanceBeyond(least16(least), partners.widest + most16(load16(blockA->r)));
}

/* A lower bound of the clearance of two placed leaves, or of one with itself, in the view; INFINITY: all their pairs
 * are excluded. Pairs that may clash are handed to the test's function, which knows their exact clearance. */
static float leafClearance(Traversal* t, ClearanceTest* test, int a, int b) {
  const Block* blocks[2];
  blocksOf(t, a, b, blocks);
  const Block* blockA = blocks[0];
  const int partner = exclusionPartner(t->exclusions, a, b);
  test->particleTests += TREE_WIDTH * TREE_WIDTH;
  if (a != b && partner == CT_NULL && greater16(all16(0), load16(blockA->r)) == 0) {
    const float clearance = clearanceOfFar(blockA, blocks[1], test->reach);
    if (clearance >= 0) {
      return clearance;
    }
  }
  const Partners partners = partnersOf(blocks[1], test->reach);
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
    const Float16 beyond = beyondMeeting(&partners, blockA, k);
    const unsigned close = greater16(all16(0), beyond) & ~out;
    least16s = min16(least16s, blend16((out | close) & 0xffff, beyond, all16(INFINITY)));
    widest = blockA->r[k] > widest ? blockA->r[k] : widest;
    for (unsigned mask = close; mask != 0; mask &= mask - 1) {
      const int l = __builtin_ctz(mask);
      const int i = a * TREE_WIDTH + k;
      const int j = b * TREE_WIDTH + l;
      const bool ofTwoBodies = bodyOfMember(t, a, k) != bodyOfMember(t, b, l);
      const double exact = test->function(test->context, i, j, ctTraversalSquaredDistance(t, i, j), ofTwoBodies);
      if (ofTwoBodies && exact < 0) {
        test->clash = true;
        return 0;
      }
      least = exact < (double)least ? (float)(exact - t->tieBand) : least;
    }
  }
  const float far = clearanceBeyond(least16(least16s), partners.widest + widest);
  return far < least ? far : least;
}

static void placeLeafInView(Traversal* t, int leaf, int body) {
  if (t->placedIn[leaf] != t->descent) {
    t->body[leaf] = body;
    placeInView(t, 0, leaf);
  }
}

/* Bounds by how much the trial changes the clearance of two leaves. */
static uint16_t boundOfPair(const Clearance* c, int a, int b) {
  return c->displacement[a] < c->displacement[b] ? c->displacement[a] : c->displacement[b];
}

static bool isMixed(const Traversal* t, int leaf) {
  return t->placedIn[leaf] == t->descent && t->body[leaf] < 0;
}

/* Tests the particles of two leaves whose spheres are too near to decide. */
static void testPair(Clearance* c, Traversal* t, ClearanceTest* test, const RunPair* pair, TestedPairs* tested, int k) {
  const int a = tested->a;
  const int b = tested->first + k;
  placeLeafInView(t, a, pair->bodyA);
  placeLeafInView(t, b, pair->bodyB);
  const float clearance = leafClearance(t, test, a, b);
  test->cost += COST_OF_LEAF_PAIR;
  if (test->clash) {
    return;
  }
  const float units = 0.999999f * clearance / c->unit; /* rounded down, as in unitsOf */
  const float most = (float)MOST_CLEARANCE;
  /* Lengths beyond those of a float, and NaN, count as no clearance. */
  const float kept = units > 0 ? units : 0;
  const uint16_t found = (uint16_t)(int)(kept < most ? kept : most);
  tested->clearance[k] = found;
  /* In a leaf where pieces meet, another piece than these may come nearer by more than this bound. */
  if (t->view->motionCount == 2 || !(isMixed(t, a) || isMixed(t, b))) {
    const uint16_t bound = boundOfPair(c, a, b);
    const uint16_t before = found > bound ? (uint16_t)(found - bound) : 0;
    uint16_t* least = rowOf(c, a) + b;
    *least = before > *least ? before : *least;
  }
}

/* Lists pairs of these leaves of A, which are of one node, with leaves of B that the trial may bring together. Returns
 * the number of entries. Has no branch on what is found, which processors would mispredict. */
static int findNear(const Clearance* c, const RunPair* pair, int begin, int end, NearPairs* near) {
  int count = 0;
  for (int a = begin; a < end; a++) {
    const int beginB = columnsBegin(pair, a);
    const uint16_t* row = rowOf(c, a);
    const uint16_t own = c->displacement[a];
    for (int first = beginB / COLUMNS_AT_ONCE * COLUMNS_AT_ONCE; first < pair->endB; first += COLUMNS_AT_ONCE) {
      const uint32_t columns = within32(row + first, c->displacement + first, own);
      near[count] = (NearPairs){a, first, columns & columnsWithin(first, beginB, pair->endB)};
      count += near[count].columns != 0;
    }
  }
  return count;
}

/* Clearance between one leaf's sphere, moved into the others' frame, and sixteen leaves' spheres. It enters the table
 * for all leaves in `measured`, since it costs no more than for one. */
static void testSpheres(Clearance* c, const Traversal* t, ClearanceTest* test, Sphere sphere, unsigned measured,
                        TestedPairs* tested) {
  const Block* spheres = leafSpheres(t, coveringNode(tested->first));
  const Float16 distance = sqrt16(squaredFrom(spheres, sphere.x, sphere.y, sphere.z));
  const Float16 radii = max16(add16(load16(spheres->r), all16(sphere.r + test->reach)), all16(0));
  const Short16 found = blendShorts(measured, allShorts(0), unitsOf(c, sub16(distance, radii)));
  const Short16 bound = minShorts(allShorts(c->displacement[tested->a]), loadShorts(c->displacement + tested->first));
  const Short16 before = lessShorts(found, bound);
  uint16_t* least = rowOf(c, tested->a) + tested->first;
  const Short16 kept = maxShorts(loadShorts(least), before);
  storeShorts(least, kept);
  storeShorts(tested->clearance, found);
  tested->left &= zeroShorts(before);
  /* Nearly all clashes are of pairs whose bound is more than three times their clearance. */
  tested->soon = tested->left & zeroShorts(lessShorts(moreShorts(kept, moreShorts(kept, kept)), bound));
  test->volumeTests += __builtin_popcount(measured);
  test->cost += COST_OF_SPHERES;
}

/* Tests pairs of leaves by their particles: those likely to clash, or all that are left. True ends the test. */
static bool testLeft(Clearance* c, Traversal* t, ClearanceTest* test, const RunPair* pair, int firstTested,
                     bool onlySoon) {
  for (int i = firstTested; i < c->testedCount; i++) {
    TestedPairs* tested = &c->tested[i];
    const unsigned now = onlySoon ? tested->soon : tested->left;
    tested->left &= ~now;
    for (unsigned pairs = now; pairs != 0; pairs &= pairs - 1) {
      testPair(c, t, test, pair, tested, __builtin_ctz(pairs));
      if (test->clash || test->cost > c->mostCost) {
        return true;
      }
    }
  }
  return false;
}

/* Tests the listed pairs of a node's leaves: by spheres, and by particles if they are likely to clash. True ends the
 * test. */
static bool testNear(Clearance* c, Traversal* t, ClearanceTest* test, const RunPair* pair, int count) {
  if (!ctReserve((void**)&c->tested, &c->testedCapacity, c->testedCount + 2 * count, sizeof(TestedPairs))) {
    test->outOfMemory = true;
    return true;
  }
  /* Runs share leaves with others only at their ends. */
  const int innerBegin = pair->beginB + isMixed(t, pair->beginB);
  const int innerEnd = pair->endB - isMixed(t, pair->endB - 1);
  const Block* spheres = leafSpheres(t, coveringNode(c->near[0].a));
  Block moved = *spheres;
  moveBlock(spheres, pair->back, 0xffff, &moved);
  const int firstTested = c->testedCount;
  for (int i = 0; i < count; i++) {
    const int a = c->near[i].a;
    const Sphere sphere = sphereOf(&moved, memberIndex(a));
    for (int half = 0; half < COLUMNS_AT_ONCE; half += TREE_WIDTH) {
      TestedPairs* tested = &c->tested[c->testedCount];
      const int first = c->near[i].first + half;
      tested->a = a;
      tested->first = first;
      tested->left = c->near[i].columns >> half & 0xffff;
      if (tested->left != 0) {
        const unsigned inner = columnsWithin(first, innerBegin > a ? innerBegin : a + 1, innerEnd) & 0xffff;
        testSpheres(c, t, test, sphere, isMixed(t, a) ? 0 : inner, tested);
        c->testedCount++;
      }
    }
  }
  return testLeft(c, t, test, pair, firstTested, true);
}

static bool testRunPair(Clearance* c, Traversal* t, const RunPair* pair, void* context) {
  ClearanceTest* test = context;
  const int firstTested = c->testedCount;
  int end;
  for (int begin = pair->beginA; begin < pair->endA; begin = end) {
    end = (coveringNode(begin) + 1) * TREE_WIDTH;
    end = end < pair->endA ? end : pair->endA;
    test->cost += (int64_t)(end - begin) * (pair->endB - columnsBegin(pair, begin)) / TREE_WIDTH;
    const int count = findNear(c, pair, begin, end, c->near);
    if (count > 0 && testNear(c, t, test, pair, count)) {
      return true;
    }
  }
  return testLeft(c, t, test, pair, firstTested, false);
}

/* Places the leaves in which pieces meet. */
static void placeMixedLeaves(Traversal* t) {
  const View* view = t->view;
  for (int p = 1; p < view->pieceCount; p++) {
    const int leaf = coveringNode(view->pieces[p].slotBegin);
    if (memberIndex(view->pieces[p].slotBegin) != 0 && t->placedIn[leaf] != t->descent) {
      CT_WIDE(placeMixedNode)(t, 0, leaf, p - 1);
    }
  }
}

/* Tests those leaves against themselves. */
static bool testMixedLeaves(Traversal* t, ClearanceTest* test) {
  for (int i = 0; i < t->mixedNodeCount && !test->clash; i++) {
    leafClearance(t, test, t->mixedNodes[i].node, t->mixedNodes[i].node);
  }
  return test->clash;
}

int64_t CT_WIDE(testByClearance)(Clearance* c, Traversal* t, const View* view, ClearanceFunction* function,
                                 void* context, ctCounts* counts) {
  CT_WIDE(startView)(t, view);
  updateWorldNodes(t);
  placeMixedLeaves(t);
  ClearanceTest test = {.function = function, .context = context};
  test.reach = (float)(view->reach + floatMargin(t->coordinateBound + fabs(view->reach)));
  test.outOfMemory = !CT_WIDE(listRuns)(c, t);
  if (!test.outOfMemory && !testMixedLeaves(t, &test)) {
    CT_WIDE(forEachRunPair)(c, t, testRunPair, &test, &test.cost);
  }
  addTests(counts, test.volumeTests, test.particleTests);
  const bool gaveUp = !test.clash && (test.outOfMemory || test.cost > c->mostCost);
  return gaveUp ? GAVE_UP : COST_OF_CLEARANCE_TEST + c->leafCount / LEAVES_PER_UNIT + test.cost;
}

/* ---- Accepting ---- */

/* Subtracts the bounds of two runs from the clearances of their leaves. */
static bool takeOff(Clearance* c, Traversal* t, const RunPair* pair, void* context) {
  (void)t;
  int64_t* cost = context;
  for (int a = pair->beginA; a < pair->endA; a++) {
    const int begin = columnsBegin(pair, a);
    uint16_t* row = rowOf(c, a);
    const Short16 own = allShorts(c->displacement[a]);
    for (int first = coveringNode(begin) * TREE_WIDTH; first < pair->endB; first += TREE_WIDTH) {
      const Short16 before = loadShorts(row + first);
      Short16 after = lessShorts(before, minShorts(own, loadShorts(c->displacement + first)));
      if (first < begin || pair->endB - first < TREE_WIDTH) {
        after = blendShorts(columnsWithin(first, begin, pair->endB) & 0xffff, before, after);
      }
      storeShorts(row + first, after);
    }
    *cost += (pair->endB - begin) / TREE_WIDTH;
  }
  return false;
}

int64_t CT_WIDE(acceptClearances)(Clearance* c, Traversal* t, const View* view) {
  int64_t cost = c->leafCount;
  if (c->boundPieces == view->pieces) { /* mostly: by the test */
    for (int i = 0; i < c->boundPairCount; i++) {
      c->displacement = displacementsOf(c, i);
      takeOff(c, t, &c->boundPairs[i], &cost);
    }
  } else {
    CT_WIDE(startView)(t, view);
    updateWorldNodes(t);
    c->isKept = CT_WIDE(listRuns)(c, t);
    if (c->isKept) {
      CT_WIDE(forEachRunPair)(c, t, takeOff, &cost, &cost);
    }
  }
  for (int i = 0; i < c->testedCount; i++) {
    const TestedPairs* tested = &c->tested[i];
    uint16_t* least = rowOf(c, tested->a) + tested->first;
    storeShorts(least, maxShorts(loadShorts(least), loadShorts(tested->clearance)));
  }
  c->testedCount = 0;
  return cost;
}
