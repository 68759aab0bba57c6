/* The pairs of leaves that a trial changes, and all that are near. A node is opened when it is first reached in a
 * trial: its members get their bodies and, where they move, boxes in the trial. Of a pair of members at least one is
 * not of the largest body, that with most leaves, since all pairs within that stay as they are: such members are rows,
 * each of which is compared with sixteen others at a time. */
#include <string.h>

#include "axisboxes.h"
#include "boxdescent.h"
#include "leafimages.h"

/* ---- Members in the trial ---- */

/* The body of the longest piece, unless more slots are static: a good guess for the body with most leaves. */
static int largestBody(const LeafTask* task) {
  int largest = 0;
  int longest = 0;
  int staticSlots = 0;
  for (int p = 0; p < task->pieceCount; p++) {
    const int end = p + 1 < task->pieceCount ? task->pieces[p + 1].slotBegin : task->tree->slotCount;
    const int slots = end - task->pieces[p].slotBegin;
    if (task->pieces[p].body == 0) {
      staticSlots += slots;
    } else if (slots > longest) {
      longest = slots;
      largest = task->pieces[p].body;
    }
  }
  return staticSlots >= longest ? 0 : largest;
}

/* Moves a position as clients do. */
static void movePosition(const ctTransform* motion, const ctLeafPositions* from, ctLeafPositions* to, int k) {
  const double* r = motion->rotation;
  to->x[k] = r[0] * from->x[k] + r[1] * from->y[k] + r[2] * from->z[k] + motion->translation[0];
  to->y[k] = r[3] * from->x[k] + r[4] * from->y[k] + r[5] * from->z[k] + motion->translation[1];
  to->z[k] = r[6] * from->x[k] + r[7] * from->y[k] + r[8] * from->z[k] + motion->translation[2];
}

/* Rounds the positions of a leaf to float. */
static void roundLeaf(const LeafTask* task, const ctLeafPositions* leaf, LeafPoints* points) {
  const double* const axes[3] = {leaf->x, leaf->y, leaf->z};
  for (int d = 0; d < 3; d++) {
    for (int i = 0; i < TREE_WIDTH; i++) {
      points->x[d][i] = (float)(axes[d][i] - task->sequence->worldOrigin[d]);
    }
  }
}

/* Writes the box around a leaf in the trial as member k of its parent. */
static void boxTrialLeaf(const LeafTask* task, int leaf, AxisBoxes* around, int k) {
  LeafPoints points;
  roundLeaf(task, &task->leaves->trial[leaf], &points);
  boxPointsLoosely(&points, task->leaves->occupied[leaf], around, k);
}

/* Moves a leaf of one body. */
static void moveLeaf(const LeafTask* task, int leaf, int body, AxisBoxes* around, int k) {
  const ctLeafPositions* restrict from = &task->leaves->state[leaf];
  ctLeafPositions* restrict to = &task->leaves->trial[leaf];
  const double* o = task->sequence->worldOrigin;
  const ctTransform motion = task->worldMotions[body];
  const double* r = motion.rotation;
  const double* t = motion.translation;
  LeafPoints points;
  for (int i = 0; i < TREE_WIDTH; i++) { /* as movePosition */
    to->x[i] = r[0] * from->x[i] + r[1] * from->y[i] + r[2] * from->z[i] + t[0];
    to->y[i] = r[3] * from->x[i] + r[4] * from->y[i] + r[5] * from->z[i] + t[1];
    to->z[i] = r[6] * from->x[i] + r[7] * from->y[i] + r[8] * from->z[i] + t[2];
  }
  for (int i = 0; i < TREE_WIDTH; i++) {
    points.x[0][i] = (float)(to->x[i] - o[0]);
    points.x[1][i] = (float)(to->y[i] - o[1]);
    points.x[2][i] = (float)(to->z[i] - o[2]);
  }
  clearEmpty(to, task->leaves->occupied[leaf]);
  boxPointsLoosely(&points, task->leaves->occupied[leaf], around, k);
}

/* Moves a leaf of many pieces, the first of which is `piece`. Returns its body. */
static int moveManyPieces(const LeafTask* task, int leaf, int piece, AxisBoxes* around, int k) {
  const ctLeafPositions* from = &task->leaves->state[leaf];
  ctLeafPositions* to = &task->leaves->trial[leaf];
  const unsigned occupied = task->leaves->occupied[leaf];
  int common = CT_NULL;
  *to = *from;
  for (int i = 0; i < TREE_WIDTH; i++) {
    while (piece + 1 < task->pieceCount && task->pieces[piece + 1].slotBegin <= leaf * TREE_WIDTH + i) {
      piece++;
    }
    const int body = task->pieces[piece].body;
    if ((occupied >> i & 1) == 0) {
      continue;
    }
    if (body != 0) {
      movePosition(&task->worldMotions[body], from, to, i);
    }
    common = i == __builtin_ctz(occupied) || common == body ? body : MANY_BODIES;
  }
  boxTrialLeaf(task, leaf, around, k);
  return common;
}

/* Moves the boxes of a mask: their middles, and half of their sizes as the motion turns them. The margin is 33 u (u =
 * 2^-24) of the sum of magnitudes for a coordinate, whose roundings are below 12 u of it. */
static void moveAxisBoxes(const AxisBoxes* from, const Frame* motion, unsigned mask, AxisBoxes* to) {
  Float16 middle[3];
  Float16 half[3];
  for (int d = 0; d < 3; d++) {
    const Float16 low = load16(from->low[d]);
    const Float16 high = load16(from->high[d]);
    middle[d] = mul16(all16(0.5f), add16(low, high));
    half[d] = mul16(all16(0.5f), sub16(high, low));
  }
  for (int d = 0; d < 3; d++) {
    const float shift = (float)motion->m[d][3];
    Float16 moved = all16(shift);
    Float16 reach = all16(0);
    Float16 size = all16(fabsf(shift));
    for (int e = 0; e < 3; e++) {
      const Float16 r = all16((float)motion->m[d][e]);
      const Float16 along = mul16(absolute16(r), half[e]);
      const Float16 product = mul16(r, middle[e]);
      moved = add16(moved, product);
      reach = add16(reach, along);
      size = add16(size, add16(absolute16(product), along));
    }
    reach = add16(reach, add16(mul16(all16(2e-6f), size), all16(FLOAT_FLOOR)));
    store16(to->low[d], blend16(mask, load16(to->low[d]), sub16(moved, reach)));
    store16(to->high[d], blend16(mask, load16(to->high[d]), add16(moved, reach)));
  }
}

/* Moves the members of a bit mask, all of one body. */
static void moveMembers(const LeafTask* task, int level, int node, unsigned mask, int body, AxisBoxes* to) {
  if (level > 1) {
    moveAxisBoxes(leafBoxes(task->leaves, task->tree, node), &task->motions[body], mask, to);
    return;
  }
  const int first = (node - task->tree->levelBegin[1]) * TREE_WIDTH;
  for (; mask != 0; mask &= mask - 1) {
    const int k = __builtin_ctz(mask);
    moveLeaf(task, first + k, body, to, k);
  }
}

/* Copies the positions of static members from the state to the trial. */
static void fillStaticLeaves(const LeafTask* task, int node, unsigned staticSlots) {
  Leaves* leaves = task->leaves;
  const int first = (node - task->tree->levelBegin[1]) * TREE_WIDTH;
  uint16_t* differs = &leaves->differs[node - task->tree->levelBegin[1]];
  for (unsigned mask = *differs & staticSlots; mask != 0; mask &= mask - 1) {
    const int leaf = first + __builtin_ctz(mask);
    leaves->trial[leaf] = leaves->state[leaf];
  }
  *differs = (uint16_t)(leaves->occupied[node] & ~staticSlots);
}

static void setBody(TrialMembers* members, unsigned mask, int body) {
  for (int k = 0; k < TREE_WIDTH; k++) {
    members->body[k] = (mask >> k & 1) != 0 ? body : members->body[k];
  }
}

/* The body of all members of a node that have particles. */
static int commonBody(const TrialMembers* members, unsigned occupied) {
  const int body = occupied == 0 ? 0 : members->body[__builtin_ctz(occupied)];
  return (occupied & ~equal16(members->body, body)) == 0 ? body : MANY_BODIES;
}

/* Opens a node of many pieces, the first of which is `piece`, and all such nodes below it. Returns its body. */
static int openMany(const LeafTask* task, int level, int node, int piece) {
  const Tree* tree = task->tree;
  Leaves* leaves = task->leaves;
  TrialMembers* members = trialMembers(leaves, tree, node);
  members->trialNumber = leaves->trialNumber;
  members->inTrial = &members->boxes;
  members->boxes = *leafBoxes(leaves, tree, node);
  const unsigned occupied = leaves->occupied[node];
  const int first = (node - tree->levelBegin[level]) * TREE_WIDTH; /* member, in its level */
  unsigned moving = 0;
  for (unsigned left = occupied; left != 0;) {
    const int k = __builtin_ctz(left);
    int end;
    const int child = tree->levelBegin[level - 1] + first + k;
    const int begin = treeSlots(tree, level - 1, child, &end);
    while (piece + 1 < task->pieceCount && task->pieces[piece + 1].slotBegin <= begin) {
      piece++;
    }
    const int next = piece + 1 < task->pieceCount ? task->pieces[piece + 1].slotBegin : tree->slotCount;
    int body = task->pieces[piece].body;
    unsigned done = 1u << k;
    if (next >= end) {
      /* As many as lie in this piece. */
      const int64_t width = (int64_t)1 << TREE_WIDTH_BITS * level;
      const int64_t wholes = next == tree->slotCount ? TREE_WIDTH : next / width - first;
      done = left & (wholes < TREE_WIDTH ? (1u << wholes) - 1 : 0xffff);
      if (body != 0) {
        moveMembers(task, level, node, done, body, &members->boxes);
      }
    } else if (level == 1) {
      body = moveManyPieces(task, child, piece, &members->boxes, k);
    } else {
      body = openMany(task, level - 1, child, piece);
      boxMembers(&trialMembers(leaves, tree, child)->boxes, &members->boxes, k);
    }
    setBody(members, done, body);
    moving |= body == 0 ? 0 : done;
    left &= ~done;
  }
  if (level == 1) {
    fillStaticLeaves(task, node, occupied & ~moving);
  }
  return commonBody(members, occupied);
}

/* Opens a node below the super-root, once a trial. Its parent must be open. */
static void openNode(const LeafTask* task, int level, int node) {
  Leaves* leaves = task->leaves;
  const Tree* tree = task->tree;
  TrialMembers* members = trialMembers(leaves, tree, node);
  if (members->trialNumber == leaves->trialNumber) {
    return;
  }
  const int k = memberIndex(node - tree->levelBegin[level]);
  const int body = trialMembers(leaves, tree, treeParent(tree, level, node))->body[k];
  const unsigned occupied = leaves->occupied[node];
  members->trialNumber = leaves->trialNumber;
  members->inTrial = body == 0 ? leafBoxes(leaves, tree, node) : &members->boxes;
  setBody(members, 0xffff, body);
  if (body != 0) {
    members->boxes = *leafBoxes(leaves, tree, node); /* empty members have boxes too */
    moveMembers(task, level, node, occupied, body, &members->boxes);
  }
  if (level == 1) {
    fillStaticLeaves(task, node, body == 0 ? occupied : 0);
  }
}

/* ---- Pairs ---- */

/* A descent. */
typedef struct LeafDescent {
  LeafTask* task;
  int largest;                        /* body */
  float limit;                        /* of squared gaps */
  float slotLimit;                    /* of squared distances of slots */
  float gaps[TREE_WIDTH][TREE_WIDTH]; /* squared: of rows from sixteen columns */
} LeafDescent;

/* The members of `columns` that are near: their squared gaps are up to the limit. */
CT_INLINE unsigned nearByGaps(LeafDescent* d, Float16 gaps, unsigned columns) {
  d->task->tests += TREE_WIDTH;
  return columns & ~greater16(gaps, all16(d->limit));
}

/* Squared gaps of member k of a node from the members of another, in the state. */
CT_INLINE Float16 gapsInState(const LeafDescent* d, int a, int k, int b) {
  const LeafTask* task = d->task;
  return squaredGaps(leafBoxes(task->leaves, task->tree, a), k, leafBoxes(task->leaves, task->tree, b));
}

/* The least of these and of those in the trial. */
CT_INLINE Float16 leastGaps(const LeafDescent* d, int a, int k, int b) {
  const LeafTask* task = d->task;
  const AxisBoxes* own = trialMembers(task->leaves, task->tree, a)->inTrial;
  const AxisBoxes* others = trialMembers(task->leaves, task->tree, b)->inTrial;
  return min16(gapsInState(d, a, k, b), squaredGaps(own, k, others));
}

/* Adds the pairs of a leaf with leaves first + k for each bit k. False if there is no memory. */
static bool addPairs(void* search, int row, int first, unsigned near) {
  LeafDescent* d = search;
  LeafPairs* pairs = d->task->pairs;
  if (!ctLeafPairsReserve(pairs, pairs->count + TREE_WIDTH)) {
    d->task->failed = true;
    return false;
  }
  int columns[TREE_WIDTH];
  const int count = indices16(near, 0, columns);
  ctLeafPair* to = pairs->pairs + pairs->count;
  for (int i = 0; i < count; i++) {
    const int column = first + columns[i];
    to[i].a = row < column ? row : column;
    to[i].b = row < column ? column : row;
    to[i].squaredGap = d->gaps[memberIndex(row)][columns[i]];
    to[i].image[0] = to[i].image[1] = to[i].image[2] = 0;
  }
  pairs->count += (size_t)count;
  return true;
}

/* Members of node a that are near node b. */
CT_VISITOR unsigned rowsInState(void* search, int level, int a, int b) {
  LeafDescent* d = search;
  const Tree* tree = d->task->tree;
  const unsigned rows = d->task->leaves->occupied[a];
  if (a == b || (rows & (rows - 1)) == 0) {
    return rows;
  }
  return nearByGaps(d, gapsInState(d, treeParent(tree, level, b), memberIndex(b - tree->levelBegin[level]), a), rows);
}

CT_VISITOR unsigned columnsInState(void* search, int level, int a, int k, int b) {
  LeafDescent* d = search;
  const Float16 gaps = gapsInState(d, a, k, b);
  (void)level;
  store16(d->gaps[k], gaps);
  return nearByGaps(d, gaps, d->task->leaves->occupied[b]) & notBefore(a, k, b);
}

/* Members of an open node that are not of the largest body. */
CT_INLINE unsigned smallerBodies(const LeafDescent* d, int node) {
  const LeafTask* task = d->task;
  return task->leaves->occupied[node] & ~equal16(trialMembers(task->leaves, task->tree, node)->body, d->largest);
}

/* Rows of the earlier of two nodes meet all members of the later. Rows of the later meet the others of the earlier,
 * which are of the largest body. */
CT_VISITOR unsigned rowsInTrial(void* search, int level, int a, int b) {
  LeafDescent* d = search;
  const LeafTask* task = d->task;
  const Tree* tree = task->tree;
  openNode(task, level, a);
  openNode(task, level, b);
  const unsigned rows = a > b && task->leaves->occupied[b] == smallerBodies(d, b) ? 0 : smallerBodies(d, a);
  if (a == b || (rows & (rows - 1)) == 0) {
    return rows;
  }
  return nearByGaps(d, leastGaps(d, treeParent(tree, level, b), memberIndex(b - tree->levelBegin[level]), a), rows);
}

CT_VISITOR unsigned columnsInTrial(void* search, int level, int a, int k, int b) {
  LeafDescent* d = search;
  const LeafTask* task = d->task;
  const int body = trialMembers(task->leaves, task->tree, a)->body[k];
  const Float16 gaps = leastGaps(d, a, k, b);
  (void)level;
  store16(d->gaps[k], gaps);
  unsigned columns = task->leaves->occupied[b];
  if (a > b) {
    columns &= ~smallerBodies(d, b);
  } else if (body != MANY_BODIES) {
    columns &= ~equal16(trialMembers(task->leaves, task->tree, b)->body, body);
  }
  if (a == b) {
    columns &= ~(smallerBodies(d, a) & ((1u << k) - 1)); /* pairs of two rows belong to the first */
  }
  return nearByGaps(d, gaps, columns);
}

/* ---- Pairs of slots ---- */

/* The slots of a leaf. */
typedef struct TrialSlots {
  LeafPoints before; /* from worldOrigin */
  LeafPoints after;
  int body[TREE_WIDTH];
  unsigned modelled; /* bits */
} TrialSlots;

static void takeSlots(const LeafTask* task, int leaf, TrialSlots* slots) {
  const Leaves* leaves = task->leaves;
  const int body = trialMembers(leaves, task->tree, treeParent(task->tree, 0, leaf))->body[memberIndex(leaf)];
  roundLeaf(task, &leaves->state[leaf], &slots->before);
  roundLeaf(task, &leaves->trial[leaf], &slots->after);
  slots->modelled = ~greater16(all16(0), load16(task->tree->leaf[leaf].r)) & 0xffff;
  if (body != MANY_BODIES) {
    storeInts16(slots->body, allInts16(body));
    return;
  }
  int piece = task->pieceCount - 1;
  for (int k = TREE_WIDTH - 1; k >= 0; k--) {
    while (task->pieces[piece].slotBegin > leaf * TREE_WIDTH + k) {
      piece--;
    }
    slots->body[k] = task->pieces[piece].body;
  }
}

CT_INLINE void loadPoints(const LeafPoints* points, Float16 x[3]) {
  for (int d = 0; d < 3; d++) {
    x[d] = load16(points->x[d]);
  }
}

/* Squared distances of slot k of a leaf from the slots of another. */
CT_INLINE Float16 squaredFromSlot(const LeafPoints* row, int k, const Float16 x[3]) {
  return squared16(sub16(x[0], all16(row->x[0][k])), sub16(x[1], all16(row->x[1][k])),
                   sub16(x[2], all16(row->x[2][k])));
}

/* Squared gaps of the slots of a leaf from member k of a node. */
CT_INLINE Float16 gapsFromMember(const LeafPoints* points, const AxisBoxes* boxes, int k) {
  Float16 x[3];
  loadPoints(points, x);
  const float low[3] = {boxes->low[0][k], boxes->low[1][k], boxes->low[2][k]};
  const float high[3] = {boxes->high[0][k], boxes->high[1][k], boxes->high[2][k]};
  return squaredGapsOfPoints(x, low, high);
}

/* Adds the pairs of slots of two leaves that move against each other and are near before the trial or in it, except
 * excluded ones. False if there is no memory. */
static bool addSlotsOf(LeafDescent* d, int leafA, const TrialSlots* a, int leafB, const uint16_t* excluded) {
  LeafTask* task = d->task;
  const Leaves* leaves = task->leaves;
  const int parent = treeParent(task->tree, 0, leafB);
  const Float16 limit = all16(d->slotLimit);
  const Float16 gaps =
      min16(gapsFromMember(&a->before, leafBoxes(leaves, task->tree, parent), memberIndex(leafB)),
            gapsFromMember(&a->after, trialMembers(leaves, task->tree, parent)->inTrial, memberIndex(leafB)));
  unsigned rows = a->modelled & ~greater16(gaps, limit);
  task->tests += TREE_WIDTH;
  if (rows == 0) {
    return true;
  }
  TrialSlots b;
  takeSlots(task, leafB, &b);
  Float16 before[3];
  Float16 after[3];
  loadPoints(&b.before, before);
  loadPoints(&b.after, after);
  task->particleTests += __builtin_popcount(rows) * TREE_WIDTH;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 squared = min16(squaredFromSlot(&a->before, k, before), squaredFromSlot(&a->after, k, after));
    unsigned near = b.modelled & ~greater16(squared, limit) & ~equal16(b.body, a->body[k]);
    near &= leafA == leafB ? ~((2u << k) - 1) : ~0u;
    near &= excluded == NULL ? ~0u : ~(unsigned)excluded[k];
    for (; near != 0; near &= near - 1) {
      const SlotPair pair = {.slotA = leafA * TREE_WIDTH + k, .slotB = leafB * TREE_WIDTH + __builtin_ctz(near)};
      if (!ctSlotPairsAdd(task->slotPairs, &pair)) {
        task->failed = true;
        return false;
      }
    }
  }
  return true;
}

/* The same for a leaf and leaves first + k for each bit k. */
static bool addSlots(void* search, int leaf, int first, unsigned near) {
  LeafDescent* d = search;
  const Exclusions* exclusions = d->task->exclusions;
  TrialSlots slots;
  takeSlots(d->task, leaf, &slots);
  int partner = exclusionsFrom(exclusions, leaf, first);
  for (; near != 0; near &= near - 1) {
    const int other = first + __builtin_ctz(near);
    const bool areExcluded = exclusionReaches(exclusions, leaf, other, &partner);
    if (!addSlotsOf(d, leaf, &slots, other, areExcluded ? exclusions->mask[partner] : NULL)) {
      return false;
    }
  }
  return true;
}

/* The largest squared distance, or gap of boxes, of particles within the cutoff. Positions in the trial and after its
 * acceptance differ by DOUBLE_MARGIN of the coordinate bound, and by Leaves.positionError; 1e-6 is 17 u of the square,
 * whose roundings are 5 u. `margin` has room for other roundings. */
static float limitOf(const LeafTask* task, double sizeInWorld, double margin) {
  const double* origin = task->sequence->worldOrigin;
  const double coordinateBound = sqrt(dot(origin, origin)) + sizeInWorld;
  const double reach = task->cutoff + DOUBLE_MARGIN * coordinateBound + task->leaves->positionError + margin;
  return (float)(reach * reach * (1 + 1e-6)) + FLOAT_FLOOR;
}

/* Sets the limits of a descent from the boxes around all particles. */
static void setLimits(LeafDescent* d, const AxisBoxes* before, const AxisBoxes* after) {
  const double size = cornerOf(before) + cornerOf(after);
  d->limit = limitOf(d->task, size, 0);
  d->slotLimit = limitOf(d->task, size, floatMargin(size + d->task->cutoff));
  d->task->size = size;
  d->task->limit = d->limit;
}

/* Starts a descent. Returns false if there are no particles. */
static bool begin(LeafDescent* d, LeafTask* task) {
  d->task = task;
  d->gaps[0][0] = 0; /* of the only leaf from itself */
  return task->leaves->occupied[treeSuperRoot(task->tree)] != 0;
}

/* Starts a descent of a trial. Returns false if all particles move as one; then members are opened in a periodic scene
 * alone. */
static bool beginTrial(LeafDescent* d, LeafTask* task) {
  const int superRoot = treeSuperRoot(task->tree);
  TrialMembers* top = trialMembers(task->leaves, task->tree, superRoot);
  if (!begin(d, task) || (task->pieceCount == 1 && !task->sequence->box.isPeriodic)) {
    return false;
  }
  task->leaves->trialNumber++;
  d->largest = largestBody(task);
  openMany(task, task->tree->levelCount, superRoot, 0);
  setLimits(d, leafBoxes(task->leaves, task->tree, superRoot), &top->boxes);
  return top->body[0] == MANY_BODIES;
}

void CT_WIDE(openMembers)(const LeafTask* task, int level, int node) {
  if (task->pieceCount > 0) {
    openNode(task, level, node);
  }
}

void CT_WIDE(listLeafPairs)(LeafTask* task) {
  LeafDescent descent;
  if (task->pieceCount > 0) {
    if (beginTrial(&descent, task)) {
      descendBoxes(&descent, task->tree, 1, (BoxVisitor){rowsInTrial, columnsInTrial, addPairs, true});
    }
  } else if (begin(&descent, task)) {
    const AxisBoxes* around = leafBoxes(task->leaves, task->tree, treeSuperRoot(task->tree));
    setLimits(&descent, around, around);
    descendBoxes(&descent, task->tree, 1, (BoxVisitor){rowsInState, columnsInState, addPairs, false});
  }
  if (task->sequence->box.isPeriodic && !task->failed) {
    CT_WIDE(listLeafImages)(task);
  }
}

void CT_WIDE(listChangedSlots)(LeafTask* task) {
  LeafDescent descent;
  if (beginTrial(&descent, task)) {
    descendBoxes(&descent, task->tree, 1, (BoxVisitor){rowsInTrial, columnsInTrial, addSlots, true});
  }
}
