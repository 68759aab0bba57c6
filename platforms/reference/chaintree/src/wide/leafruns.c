#include "leafruns.h"

/* ---- Runs ---- */

bool CT_WIDE(listRuns)(Clearance* c, const Traversal* t) {
  const View* view = t->view;
  /* Each piece may be followed by a leaf of many pieces. */
  if (!ctReserve((void**)&c->runs, &c->runCapacity, 2 * view->pieceCount, sizeof(LeafRun))) {
    return false;
  }
  c->runCount = 0;
  int done = 0; /* one past the last leaf of many pieces so far */
  for (int p = 0; p < view->pieceCount;) {
    const int first = coveringNode(view->pieces[p].slotBegin);
    const int begin = first > done ? first : done;
    const int slotEnd = p + 1 < view->pieceCount ? view->pieces[p + 1].slotBegin : t->tree->slotCount;
    const int last = coveringNode(slotEnd - 1);
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

/* ---- Bounds ---- */

/* Bounds how far a rigid motion displaces the particles of these leaves, in units, rounded up. A particle at x + y,
 * where x is the centre of its leaf's sphere, is displaced by (R - 1) x + t, which is computed, and by (R - 1) y, which
 * is no longer than |R - 1| r. With u = 2^-24, v = 2^-53, and the view's coordinate bound E:
 *
 * - |R - 1| = sqrt(3 - trace R), the chord. The trace of a product of k rotations has an error of up to 12 k v,
 *   which 1e-13 = 900 v exceeds for k <= 75. Beyond, the chord is too short by up to sqrt(12 k v): up to k = 10^6
 *   by less than 4e-5, and its product with r by less than the unit that remains below.
 * - (R - 1) x is off by up to 4 u sqrt(2) |R - 1| E (entries, three products, their sums), and by 19 u |R - 1| E
 *   for the rounding of x itself (see FLOAT_MARGIN); t by 3 u |t|. If |t| > 2 |R - 1| E, the sum is no shorter than
 *   |t| / 2, and those 3 u |t| are less than the 84 u |t| of the factor 1.00001 = 1 + 168 u; else they are less than
 *   6 u |R - 1| E. Together 31 u |R - 1| E, of the 67 u |R - 1| E of FLOAT_MARGIN.
 * - Root, product and sums are off by up to 8 u of their value: another part of that factor.
 * - unitsOf rounds down by less than 17 u of the value, which that factor exceeds too, and by less than a unit. Two
 *   are added: the other one covers a quarter of a unit by which clearances of skipped pairs may be too large, see
 *   ctClearanceSkip, and what positions in double differ by from trial to trial, DOUBLE_MARGIN E, as long as E is
 *   less than 3 10^7 times the radius of the largest leaf. */
static void boundDisplacements(Clearance* c, const Traversal* t, const Frame* motion, int begin, int end) {
  /* R - 1 and t: small where the motion is small. */
  float change[12];
  double trace = 0;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 4; j++) {
      change[4 * i + j] = (float)(motion->m[i][j] - (i == j));
    }
    trace += motion->m[i][i];
  }
  const double chord = sqrt(larger(0, 3 - trace) + 1e-13);
  const Float16 margin = all16((float)(FLOAT_MARGIN * chord * t->coordinateBound + 2 * (double)c->unit));
  for (int block = coveringNode(begin); block <= coveringNode(end - 1); block++) {
    const Block* spheres = leafSpheres(t, block);
    const Float16 x = moved16(spheres, change);
    const Float16 y = moved16(spheres, change + 4);
    const Float16 z = moved16(spheres, change + 8);
    const Float16 centre = sqrt16(squared16(x, y, z));
    const Float16 turned = mul16(max16(load16(spheres->r), all16(0)), all16((float)chord));
    const Float16 bounds = mul16(add16(add16(centre, turned), margin), all16(1.00001f));
    storeShorts(c->displacement + TREE_WIDTH * block, unitsOf(c, bounds));
  }
}

/* The motion of a body in the frame of another, whose motion is undone by `back`. */
static Frame motionInFrame(const View* view, int body, int frame, const Frame* back) {
  return frame == 0 ? view->motions[body] : transformCompose(back, &view->motions[body]);
}

/* Bounds the displacement of a leaf of many pieces in the frame of a run of one piece. The run's own leaves get no
 * bound: the bound of a pair is the lesser of two. */
static void boundDisplacementOfMany(Clearance* c, const Traversal* t, const LeafRun* many, const LeafRun* run) {
  const View* view = t->view;
  const int body = view->pieces[run->firstPiece].body;
  const Frame back = transformInverse(&view->motions[body]);
  uint16_t most = 0;
  for (int p = many->firstPiece; p <= many->lastPiece; p++) {
    if (view->pieces[p].body != body) {
      const Frame between = motionInFrame(view, view->pieces[p].body, body, &back);
      boundDisplacements(c, t, &between, many->begin, many->end);
      most = c->displacement[many->begin] > most ? c->displacement[many->begin] : most;
    }
  }
  memset(c->displacement + run->begin, 0xff, (size_t)(run->end - run->begin) * sizeof *c->displacement);
  c->displacement[many->begin] = most;
}

/* Bounds the displacements of two runs of one piece each, in the frame of the other. */
static void boundDisplacementsOfPieces(Clearance* c, const Traversal* t, RunPair* pair) {
  const Frame back = transformInverse(&t->view->motions[pair->bodyA]);
  const Frame between = motionInFrame(t->view, pair->bodyB, pair->bodyA, &back);
  const Frame other = transformInverse(&between);
  floatMotion(&other, pair->back);
  /* A distance changes by no more than either of its ends is displaced in the frame of the other. */
  boundDisplacements(c, t, &between, pair->beginA, pair->endA);
  boundDisplacements(c, t, &between, pair->beginB, pair->endB);
}

bool CT_WIDE(forEachRunPair)(Clearance* c, Traversal* t, RunPairFunction* visit, void* context, int64_t* cost) {
  const Piece* pieces = t->view->pieces;
  c->boundPieces = NULL;
  c->boundPairCount = 0;
  for (int i = 0; i < c->runCount; i++) {
    for (int j = i + 1; j < c->runCount; j++) {
      const LeafRun* a = &c->runs[i];
      const LeafRun* b = &c->runs[j];
      c->displacement = displacementsOf(c, c->boundPairCount);
      RunPair pair = {a->begin, a->end, pieces[a->firstPiece].body, b->begin, b->end, pieces[b->firstPiece].body, {0}};
      if (hasManyPieces(a) && hasManyPieces(b)) {
        c->displacement[a->begin] = MOST_CLEARANCE;
        c->displacement[b->begin] = MOST_CLEARANCE;
      } else if (hasManyPieces(a) || hasManyPieces(b)) {
        boundDisplacementOfMany(c, t, hasManyPieces(a) ? a : b, hasManyPieces(a) ? b : a);
      } else if (pair.bodyA != pair.bodyB) {
        boundDisplacementsOfPieces(c, t, &pair);
      } else {
        continue;
      }
      if (c->boundPairCount < MOST_BOUND_PAIRS) {
        c->boundPairs[c->boundPairCount] = pair;
      }
      c->boundPairCount++;
      *cost += COST_OF_RUN_PAIR + (pair.endA - pair.beginA + pair.endB - pair.beginB) / LEAVES_PER_UNIT;
      if (visit(c, t, &pair, context)) {
        return true;
      }
    }
  }
  c->boundPieces = c->boundPairCount <= MOST_BOUND_PAIRS ? pieces : NULL;
  return false;
}
