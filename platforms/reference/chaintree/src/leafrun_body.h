/* Bodies that move against each other in a view, and how far; compiled once for each instruction set by the file that
 * includes this. */
#ifndef CT_LEAFRUN_BODY_H_
#define CT_LEAFRUN_BODY_H_

#include "clearance.h"
#include "costs.h"
#include "view_body.h"

/* Two bodies that move against each other. */
typedef struct RunPair {
  int beginA; /* leaves */
  int endA;
  int motionA;
  int beginB;
  int endB;
  int motionB;
  float back[12]; /* what takes A, at rest, to where B, at rest, sees it in the view, if both are of one piece */
} RunPair;

/* ---- Bodies ---- */

/* False if there is no memory. */
static bool listRuns(Clearance* c, const Traversal* t) {
  const View* view = t->view;
  /* A piece may be followed by a leaf of many. */
  if (!ctReserve((void**)&c->runs, &c->runCapacity, 2 * view->pieceCount, sizeof(LeafRun))) {
    return false;
  }
  c->runCount = 0;
  int done = 0; /* leaves of many so far end here */
  for (int p = 0; p < view->pieceCount;) {
    const int first = view->pieces[p].slotBegin / TREE_WIDTH;
    const int begin = first > done ? first : done;
    const int slotEnd = p + 1 < view->pieceCount ? view->pieces[p + 1].slotBegin : t->tree->slotCount;
    const int last = (slotEnd - 1) / TREE_WIDTH;
    int q = p; /* the last piece in that leaf */
    while (q + 1 < view->pieceCount && view->pieces[q + 1].slotBegin < (last + 1) * TREE_WIDTH) {
      q++;
    }
    const bool meetsMany = q > p + 1;
    const int end = last + !meetsMany;
    if (begin < end) {
      c->runs[c->runCount++] = (LeafRun){begin, end, p, p};
    }
    if (meetsMany) {
      c->runs[c->runCount++] = (LeafRun){last, last + 1, p, q};
      done = last + 1;
    }
    p = meetsMany ? q : p + 1;
  }
  return true;
}

static bool hasManyPieces(const LeafRun* run) {
  return run->firstPiece < run->lastPiece;
}

/* ---- How far bodies go ---- */

/* The spheres of sixteen leaves at rest. */
static const Block* leafSpheres(const Traversal* t, int block) {
  return &t->world[t->entryOf[t->tree->levelBegin[1] + block]];
}

static Sphere leafSphere(const Traversal* t, int leaf) {
  return sphereOf(leafSpheres(t, leaf / TREE_WIDTH), leaf % TREE_WIDTH);
}

/* Turns lengths into units, rounded down. */
CT_INLINE Short16 unitsOf(const Clearance* c, Float16 lengths) {
  const Float16 most = all16((float)MOST_CLEARANCE);
  return shortsOf16(min16(max16(mul16(lengths, all16(0.999999f / c->unit)), all16(0)), most));
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
    const Float16 bounds = mul16(add16(add16(centre, turned), room), all16(1.00001f));
    storeShorts(c->shift + TREE_WIDTH * block, unitsOf(c, bounds));
  }
}

/* The shift of a leaf of many as a body of one piece sees it, and no limit for those of that. */
static void boundShiftOfMany(Clearance* c, const Traversal* t, const LeafRun* many, const LeafRun* run) {
  const View* view = t->view;
  const int motion = view->pieces[run->firstPiece].motion;
  const Frame back = transformInverse(&view->motions[motion]);
  uint16_t most = 0;
  for (int p = many->firstPiece; p <= many->lastPiece; p++) {
    if (view->pieces[p].motion != motion) {
      const Frame between = transformCompose(&back, &view->motions[view->pieces[p].motion]);
      boundShifts(c, t, &between, many->begin, many->end);
      most = c->shift[many->begin] > most ? c->shift[many->begin] : most;
    }
  }
  memset(c->shift + run->begin, 0xff, (size_t)(run->end - run->begin) * sizeof *c->shift);
  c->shift[many->begin] = most;
}

/* The same between two bodies of one piece. */
static void boundShiftsOfPieces(Clearance* c, const Traversal* t, RunPair* pair) {
  const Frame back = transformInverse(&t->view->motions[pair->motionA]);
  const Frame between = transformCompose(&back, &t->view->motions[pair->motionB]);
  const Frame other = transformInverse(&between);
  floatMotion(&other, pair->back);
  /* A distance changes by no more than either of its ends is displaced. */
  boundShifts(c, t, &between, pair->beginA, pair->endA);
  boundShifts(c, t, &between, pair->beginB, pair->endB);
}

/* Calls `visit` for each two bodies that move against each other, their shifts bounded; ends with true as soon as that
 * does. Adds what the bounds cost. */
typedef bool RunPairFunction(Clearance* c, Traversal* t, const RunPair* pair, void* context);

static bool forEachRunPair(Clearance* c, Traversal* t, RunPairFunction* visit, void* context, int64_t* cost) {
  const Piece* pieces = t->view->pieces;
  for (int i = 0; i < c->runCount; i++) {
    for (int j = i + 1; j < c->runCount; j++) {
      const LeafRun* a = &c->runs[i];
      const LeafRun* b = &c->runs[j];
      RunPair pair = {a->begin, a->end, pieces[a->firstPiece].motion, b->begin, b->end, pieces[b->firstPiece].motion,
                      {0}};
      if (hasManyPieces(a) && hasManyPieces(b)) {
        c->shift[a->begin] = MOST_CLEARANCE;
        c->shift[b->begin] = MOST_CLEARANCE;
      } else if (hasManyPieces(a) || hasManyPieces(b)) {
        boundShiftOfMany(c, t, hasManyPieces(a) ? a : b, hasManyPieces(a) ? b : a);
      } else if (pair.motionA != pair.motionB) {
        boundShiftsOfPieces(c, t, &pair);
      } else {
        continue;
      }
      *cost += COST_OF_RUN_PAIR + (pair.endA - pair.beginA + pair.endB - pair.beginB) / LEAVES_A_UNIT;
      if (visit(c, t, &pair, context)) {
        return true;
      }
    }
  }
  return false;
}

#endif /* CT_LEAFRUN_BODY_H_ */
