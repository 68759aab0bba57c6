/* The pairs of leaves that a trial changes, and all that are near. For a trial, boxes before it and in it are descended
 * pair by pair. A node is opened when it is first reached: its members get their bodies and, where they move, boxes in
 * the trial. Of a pair of members at least one is not of the largest body, that with most leaves, since all pairs
 * within that stay as they are: such members are rows, each of which is compared with sixteen others at a time. */
#include <string.h>

#include "axisboxes.h"
#include "boxdescent.h"

/* Of a member that has particles of many bodies. */
enum { MANY_BODIES = -1 };

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

/* Writes the box around a leaf in the trial as member k of its parent. */
static void boxTrialLeaf(const LeafTask* task, int leaf, AxisBoxes* around, int k) {
  const ctLeafPositions* own = &task->leaves->trial[leaf];
  const double* const axes[3] = {own->x, own->y, own->z};
  LeafPoints points;
  for (int d = 0; d < 3; d++) {
    for (int i = 0; i < TREE_WIDTH; i++) {
      points.x[d][i] = (float)(axes[d][i] - task->sequence->worldOrigin[d]);
    }
  }
  boxPoints(&points, task->leaves->occupied[leaf], around, k);
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
  boxPoints(&points, task->leaves->occupied[leaf], around, k);
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

/* Opens a node of this body, once a trial. */
static void openNode(const LeafTask* task, int level, int node, int body) {
  Leaves* leaves = task->leaves;
  TrialMembers* members = trialMembers(leaves, task->tree, node);
  if (members->trialNumber == leaves->trialNumber) {
    return;
  }
  const unsigned occupied = leaves->occupied[node];
  members->trialNumber = leaves->trialNumber;
  setBody(members, 0xffff, body);
  if (body != 0) {
    members->boxes = *leafBoxes(leaves, task->tree, node); /* empty members have boxes too */
    moveMembers(task, level, node, occupied, body, &members->boxes);
  }
  if (level == 1) {
    fillStaticLeaves(task, node, body == 0 ? occupied : 0);
  }
}

/* ---- Pairs ---- */

/* A node that the descent has reached: member k of its parent. */
typedef struct Reached {
  int node;
  int k;
  const AxisBoxes* before; /* of its parent's members */
  const AxisBoxes* after;
  int body;
} Reached;

/* An opened node. */
typedef struct Opened {
  const AxisBoxes* before; /* of its members */
  const AxisBoxes* after;
  const int* body;
  unsigned occupied;
  unsigned rows; /* members that are not of the largest body */
  int first;     /* member, in its level */
} Opened;

/* A descent. */
typedef struct LeafDescent {
  LeafTask* task;
  int largest;                        /* body */
  float limit;                        /* of squared gaps */
  float gaps[TREE_WIDTH][TREE_WIDTH]; /* squared: of rows from sixteen columns */
} LeafDescent;

/* The members of `columns` that are near: their squared gaps are up to the limit. */
CT_INLINE unsigned nearByGaps(LeafDescent* d, Float16 gaps, unsigned columns) {
  d->task->tests += TREE_WIDTH;
  return columns & ~greater16(gaps, all16(d->limit));
}

/* Squared gaps of a box from others: the least before the trial and in it. */
CT_INLINE Float16 leastGaps(const AxisBoxes* before, const AxisBoxes* after, int k, const Opened* others) {
  return min16(squaredGaps(before, k, others->before), squaredGaps(after, k, others->after));
}

/* Adds the pairs of a leaf with leaves first + k for each bit k. False if there is no memory. */
static bool addPairs(LeafDescent* d, int row, int first, unsigned near) {
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
  }
  pairs->count += (size_t)count;
  return true;
}

static Opened openReached(const LeafDescent* d, int level, const Reached* reached) {
  const LeafTask* task = d->task;
  openNode(task, level, reached->node, reached->body);
  const TrialMembers* members = trialMembers(task->leaves, task->tree, reached->node);
  Opened o;
  o.before = leafBoxes(task->leaves, task->tree, reached->node);
  o.after = reached->body == 0 ? o.before : &members->boxes;
  o.body = members->body;
  o.occupied = task->leaves->occupied[reached->node];
  o.rows = o.occupied & ~equal16(members->body, d->largest);
  o.first = (reached->node - task->tree->levelBegin[level]) * TREE_WIDTH;
  return o;
}

static void descendLeaves(LeafDescent* d, int level, const Reached* a, const Reached* b);

static Reached reachMember(const LeafDescent* d, int level, const Opened* o, int k) {
  const int node = d->task->tree->levelBegin[level - 1] + o->first + k;
  return (Reached){node, k, o->before, o->after, o->body[k]};
}

/* Compares row k of an opened node with these columns of another. */
static void searchRow(LeafDescent* d, int level, const Opened* rows, int k, const Opened* others, unsigned columns) {
  const Float16 gaps = leastGaps(rows->before, rows->after, k, others);
  unsigned near = nearByGaps(d, gaps, columns);
  if (near == 0) {
    return;
  }
  if (level == 1) {
    store16(d->gaps[k], gaps);
    addPairs(d, rows->first + k, others->first, near);
    return;
  }
  const Reached row = reachMember(d, level, rows, k);
  for (; near != 0 && !d->task->failed; near &= near - 1) {
    const Reached column = reachMember(d, level, others, __builtin_ctz(near));
    if (row.node <= column.node) {
      descendLeaves(d, level - 1, &row, &column);
    } else {
      descendLeaves(d, level - 1, &column, &row);
    }
  }
}

/* The columns that a row moves against, all in one node. */
static unsigned columnsOfRow(const Opened* rows, int k, const Opened* others) {
  if (rows->body[k] == MANY_BODIES) {
    return others->occupied;
  }
  return others->occupied & ~equal16(others->body, rows->body[k]);
}

/* Lists the pairs of leaves below two nodes of a level, or of one node with itself. */
static void descendLeaves(LeafDescent* d, int level, const Reached* a, const Reached* b) {
  const Opened first = openReached(d, level, a);
  if (a->node == b->node) {
    for (unsigned left = first.rows; left != 0 && !d->task->failed; left &= left - 1) {
      const int k = __builtin_ctz(left);
      /* Pairs of two rows belong to the first. */
      const unsigned earlier = first.rows & ((1u << k) - 1);
      searchRow(d, level, &first, k, &first, columnsOfRow(&first, k, &first) & ~earlier);
    }
    return;
  }
  const Opened second = openReached(d, level, b);
  unsigned left = first.rows;
  if ((left & (left - 1)) != 0) {
    left = nearByGaps(d, leastGaps(b->before, b->after, b->k, &first), left);
  }
  for (; left != 0 && !d->task->failed; left &= left - 1) {
    const int k = __builtin_ctz(left);
    searchRow(d, level, &first, k, &second, columnsOfRow(&first, k, &second));
  }
  const unsigned others = first.occupied & ~first.rows;
  left = others == 0 ? 0 : second.rows;
  if ((left & (left - 1)) != 0) {
    left = nearByGaps(d, leastGaps(a->before, a->after, a->k, &second), left);
  }
  for (; left != 0 && !d->task->failed; left &= left - 1) {
    searchRow(d, level, &second, __builtin_ctz(left), &first, others);
  }
}

/* ---- Pairs of the state ---- */

/* Members of node a that are near node b. */
CT_INLINE unsigned rowsOfState(void* search, int level, int a, int b) {
  LeafDescent* d = search;
  const Tree* tree = d->task->tree;
  const Leaves* leaves = d->task->leaves;
  const unsigned rows = leaves->occupied[a];
  if (a == b || (rows & (rows - 1)) == 0) {
    return rows;
  }
  const AxisBoxes* around = leafBoxes(leaves, tree, treeParent(tree, level, b));
  const int k = memberIndex(b - tree->levelBegin[level]);
  return nearByGaps(d, squaredGaps(around, k, leafBoxes(leaves, tree, a)), rows);
}

CT_INLINE unsigned columnsOfState(void* search, int level, int a, int k, int b) {
  LeafDescent* d = search;
  const Tree* tree = d->task->tree;
  const Leaves* leaves = d->task->leaves;
  const Float16 gaps = squaredGaps(leafBoxes(leaves, tree, a), k, leafBoxes(leaves, tree, b));
  (void)level;
  store16(d->gaps[k], gaps);
  return nearByGaps(d, gaps, leaves->occupied[b]);
}

CT_INLINE bool addPairsOfState(void* search, int leaf, int first, unsigned near) {
  return addPairs(search, leaf, first, near);
}

/* ---- The task ---- */

/* The largest distance from worldOrigin of a corner of member 0. */
static double cornerOf(const AxisBoxes* boxes) {
  double corner[3];
  for (int d = 0; d < 3; d++) {
    corner[d] = larger(fabs((double)boxes->low[d][0]), fabs((double)boxes->high[d][0]));
  }
  return sqrt(dot(corner, corner));
}

/* The largest squared gap of boxes around particles within the cutoff. Positions in the trial and after its acceptance
 * differ by DOUBLE_MARGIN of the coordinate bound, and by Leaves.positionError; 1e-6 is 17 u of the square, whose
 * roundings are 5 u. */
static float gapLimit(const LeafTask* task, const AxisBoxes* before, const AxisBoxes* after) {
  const double* origin = task->sequence->worldOrigin;
  const double coordinateBound = sqrt(dot(origin, origin)) + cornerOf(before) + cornerOf(after);
  const double reach = task->cutoff + DOUBLE_MARGIN * coordinateBound + task->leaves->positionError;
  return (float)(reach * reach * (1 + 1e-6)) + FLOAT_FLOOR;
}

/* Lists pairs of leaves that the trial changes. */
static void listChanged(LeafDescent* d) {
  const Tree* tree = d->task->tree;
  Leaves* leaves = d->task->leaves;
  const int superRoot = treeSuperRoot(tree);
  const int level = tree->levelCount;
  leaves->trialNumber++;
  d->largest = largestBody(d->task);
  const Reached top = {.node = superRoot, .body = openMany(d->task, level, superRoot, 0)};
  d->limit = gapLimit(d->task, leafBoxes(leaves, tree, superRoot), &trialMembers(leaves, tree, superRoot)->boxes);
  descendLeaves(d, level, &top, &top);
}

/* Lists all near pairs of leaves. */
static void listAll(LeafDescent* d) {
  const Tree* tree = d->task->tree;
  const AxisBoxes* around = leafBoxes(d->task->leaves, tree, treeSuperRoot(tree));
  d->limit = gapLimit(d->task, around, around);
  descendBoxes(d, tree, 1, rowsOfState, columnsOfState, addPairsOfState);
}

void CT_WIDE(listLeafPairs)(LeafTask* task) {
  if (task->leaves->occupied[treeSuperRoot(task->tree)] == 0 || task->pieceCount == 1) {
    return; /* no particles, or all of them move as one */
  }
  LeafDescent descent;
  descent.task = task;
  descent.gaps[0][0] = 0; /* of the only leaf from itself */
  if (task->pieceCount > 0) {
    listChanged(&descent);
  } else {
    listAll(&descent);
  }
}
