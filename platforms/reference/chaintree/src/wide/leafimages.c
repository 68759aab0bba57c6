/* Pairs of leaves with periodic images. What moves is a few groups of members, as in images.c; in the state everything
 * counts as moving. Each group is compared with the scene from the root down, until both are of one level; then both
 * descend. Two leaves may be near in many images, of which each makes a pair. */
#include "leafimages.h"

#include <stdlib.h>

#include "axisboxes.h"
#include "boxdescent.h"
#include "nearimages.h"

/* A search for pairs of leaves with images. */
typedef struct LeafImages {
  LeafTask* task;
  Lattice lattice;
  float reach;  /* of boxes, with room for rounding */
  float margin; /* of boxes that are shifted */
} LeafImages;

/* The boxes around the members of a node before the trial and in it; of the state twice the same. */
typedef struct BothBoxes {
  const AxisBoxes* before;
  const AxisBoxes* after;
} BothBoxes;

static BothBoxes bothBoxes(const LeafTask* task, int node) {
  const AxisBoxes* before = leafBoxes(task->leaves, task->tree, node);
  return (BothBoxes){before, task->pieceCount == 0 ? before : trialMembers(task->leaves, task->tree, node)->inTrial};
}

/* ---- Bodies ---- */

/* The members (bits) of an open node that have particles and are of this body. */
static unsigned membersOfBody(const LeafTask* task, int node, int body) {
  return task->leaves->occupied[node] & equal16(trialMembers(task->leaves, task->tree, node)->body, body);
}

/* Members that move, or of which a part does. */
static unsigned movingLeaves(const LeafTask* task, int node) {
  const unsigned occupied = task->leaves->occupied[node];
  return task->pieceCount == 0 ? occupied : occupied & ~membersOfBody(task, node, 0);
}

/* Members of node b that are compared with member k of node a, which moves. Where both move, the earlier one is
 * compared with the later one, unless they are of one body that does not turn, and so keeps its distances to its own
 * images. */
static unsigned comparedLeaves(const LeafTask* task, int level, int a, int k, int b) {
  const unsigned occupied = task->leaves->occupied[b];
  if (task->pieceCount == 0) {
    return occupied & membersNotBefore(a, k, b);
  }
  const unsigned movesInPart = level > 1 ? membersOfBody(task, b, MANY_BODIES) : 0;
  unsigned skipped = movingLeaves(task, b) & ~movesInPart & ~membersNotBefore(a, k, b);
  const int body = trialMembers(task->leaves, task->tree, a)->body[k];
  if (body != MANY_BODIES && isTranslation(&task->motions[body])) {
    skipped |= membersOfBody(task, b, body);
  }
  return occupied & ~skipped;
}

/* ---- Boxes that meet ---- */

/* How far sixteen boxes are from member k of some boxes, in box vectors, and within which distances they meet. */
typedef struct Apart {
  Float16 vectors[3];
  Float16 reaches[3];
} Apart;

CT_INLINE Apart boxesApartInVectors(const LeafImages* search, const AxisBoxes* row, int k, const AxisBoxes* others) {
  const Lattice* lattice = &search->lattice;
  Float16 apart[3];
  Float16 half[3];
  for (int d = 0; d < 3; d++) {
    const Float16 low = sub16(load16(others->low[d]), all16(row->high[d][k]));
    const Float16 high = sub16(load16(others->high[d]), all16(row->low[d][k]));
    apart[d] = mul16(add16(low, high), all16(0.5f));
    half[d] = mul16(sub16(high, low), all16(0.5f));
  }
  Apart boxes;
  vectorsApart(lattice, apart, boxes.vectors);
  for (int i = 0; i < 3; i++) {
    boxes.reaches[i] = all16(search->reach * lattice->across[i]);
    for (int d = i; d < 3; d++) {
      boxes.reaches[i] = add16(boxes.reaches[i], mul16(half[d], all16(fabsf(lattice->inverse[i][d]))));
    }
  }
  return boxes;
}

/* The members (bits) of `others` that meet member k of some boxes in an image with a shift. */
CT_INLINE unsigned meetBoxes(const LeafImages* search, const AxisBoxes* row, int k, const AxisBoxes* others) {
  const Apart apart = boxesApartInVectors(search, row, k, others);
  return meetImages16(apart.vectors, apart.reaches);
}

/* The same before the trial or in it. */
CT_INLINE unsigned meetBoth(const LeafImages* search, BothBoxes row, int k, BothBoxes others) {
  unsigned near = meetBoxes(search, row.before, k, others.before);
  if (row.after != row.before || others.after != others.before) {
    near |= meetBoxes(search, row.after, k, others.after);
  }
  search->task->tests += TREE_WIDTH;
  return near;
}

/* ---- Pairs ---- */

/* The image of a leaf in which each of sixteen others is nearest. */
typedef struct NearestImages {
  float n[3][TREE_WIDTH];
  float gaps[TREE_WIDTH]; /* squared */
  unsigned many;          /* members that may meet it in several images */
} NearestImages;

/* Squared gaps between box k of some, shifted, and sixteen others. */
CT_INLINE Float16 gapsOfShifted(const AxisBoxes* row, int k, const AxisBoxes* others, const Float16 shift[3],
                                float margin) {
  Float16 gap[3];
  for (int d = 0; d < 3; d++) {
    const Float16 high = add16(all16(row->high[d][k] + margin), shift[d]);
    const Float16 low = add16(all16(row->low[d][k] - margin), shift[d]);
    gap[d] = max16(max16(sub16(load16(others->low[d]), high), sub16(low, load16(others->high[d]))), all16(0));
  }
  return squared16(gap[0], gap[1], gap[2]);
}

/* Adds what is so before the trial, or in it. */
CT_INLINE void addNearest(const LeafImages* search, const AxisBoxes* row, int k, const AxisBoxes* others, bool isFirst,
                          NearestImages* nearest) {
  const Apart apart = boxesApartInVectors(search, row, k, others);
  Float16 shift[3] = {all16(0), all16(0), all16(0)};
  for (int i = 0; i < 3; i++) {
    const Float16 whole = nearestWhole16(apart.vectors[i]);
    const Float16 off = absolute16(sub16(apart.vectors[i], whole));
    nearest->many |= ~greater16(sub16(all16(1), off), apart.reaches[i]);
    nearest->many |= isFirst ? 0 : greater16(absolute16(sub16(whole, load16(nearest->n[i]))), all16(0.5f));
    store16(nearest->n[i], whole);
    for (int d = 0; d <= i; d++) {
      shift[d] = add16(shift[d], mul16(whole, all16((float)search->task->sequence->box.vectors[i][d])));
    }
  }
  const Float16 gaps = gapsOfShifted(row, k, others, shift, search->margin);
  store16(nearest->gaps, isFirst ? gaps : min16(gaps, load16(nearest->gaps)));
}

/* Adds a pair of a shifted leaf and another. */
static bool addImage(const LeafImages* search, int leaf, int other, const int n[3], float squaredGap) {
  LeafTask* task = search->task;
  LeafPairs* pairs = task->pairs;
  if (!ctLeafPairsReserve(pairs, pairs->count + 1)) {
    task->failed = true;
    return false;
  }
  const bool isLower = leaf <= other;
  ctLeafPair* pair = &pairs->pairs[pairs->count++];
  *pair = (ctLeafPair){.a = isLower ? leaf : other, .b = isLower ? other : leaf, .squaredGap = squaredGap};
  for (int d = 0; d < 3; d++) {
    if (abs(n[d]) > CT_MOST_IMAGE) {
      task->isTooLong = true;
      return false;
    }
    pair->image[d] = isLower ? n[d] : -n[d];
  }
  return true;
}

/* Writes the box around members (bits) to member 0 of another. */
static void boxGroup(const AxisBoxes* from, unsigned members, AxisBoxes* around) {
  AxisBoxes kept = *from;
  for (int d = 0; d < 3; d++) {
    store16(kept.low[d], blend16(members, all16(INFINITY), load16(kept.low[d])));
    store16(kept.high[d], blend16(members, all16(-INFINITY), load16(kept.high[d])));
  }
  clearAxisBoxes(around);
  boxMembers(&kept, around, 0);
}

/* Writes the box around member k before the trial and in it. */
static void boundBoth(const AxisBoxes* before, const AxisBoxes* after, int k, double low[3], double high[3]) {
  for (int d = 0; d < 3; d++) {
    low[d] = lesser((double)before->low[d][k], (double)after->low[d][k]);
    high[d] = larger((double)before->high[d][k], (double)after->high[d][k]);
  }
}

/* Adds the pairs of leaf k of node a with leaves (bits) of node b in all images that are near. */
static bool addManyImages(const LeafImages* search, int a, int k, int b, unsigned columns) {
  const LeafTask* task = search->task;
  const BothBoxes row = bothBoxes(task, a);
  const BothBoxes others = bothBoxes(task, b);
  const int leaf = memberOfNode(task->tree, 1, a, k);
  const int first = memberOfNode(task->tree, 1, b, 0);
  AxisBoxes around[2];
  boxGroup(others.before, columns, &around[0]);
  boxGroup(others.after, columns, &around[1]);
  double low[2][3];
  double high[2][3];
  boundBoth(row.before, row.after, k, low[0], high[0]);
  boundBoth(&around[0], &around[1], 0, low[1], high[1]);
  ImageRange range = ctImageRange(&task->sequence->box, low[0], high[0], low[1], high[1], (double)search->reach);
  while (ctNextImage(&range)) {
    const Image* image = &range.image;
    const Float16 shift[3] = {all16((float)image->shift[0]), all16((float)image->shift[1]),
                              all16((float)image->shift[2])};
    const Float16 least = min16(gapsOfShifted(row.before, k, others.before, shift, search->margin),
                                gapsOfShifted(row.after, k, others.after, shift, search->margin));
    unsigned near = columns & ~greater16(least, all16(task->limit));
    if (a == b && !isFirstOfOpposite(image->n)) {
      near &= ~(1u << k); /* the leaf and itself */
    }
    float gaps[TREE_WIDTH];
    store16(gaps, least);
    for (; near != 0; near &= near - 1) {
      const int l = __builtin_ctz(near);
      if (!addImage(search, leaf, first + l, image->n, gaps[l])) {
        return false;
      }
    }
  }
  return true;
}

/* Adds the pairs of leaf k of node a with leaves (bits) of node b that are near. */
static bool addImages(const LeafImages* search, int a, int k, int b, unsigned columns) {
  const LeafTask* task = search->task;
  const BothBoxes row = bothBoxes(task, a);
  const BothBoxes others = bothBoxes(task, b);
  unsigned near = meetBoth(search, row, k, others) & columns;
  if (near == 0) { /* mostly */
    return true;
  }
  NearestImages nearest = {.many = 0};
  addNearest(search, row.before, k, others.before, true, &nearest);
  if (row.after != row.before || others.after != others.before) {
    addNearest(search, row.after, k, others.after, false, &nearest);
  }
  near &= nearest.many | ~greater16(load16(nearest.gaps), all16(task->limit));
  near &= near == 0 ? 0 : comparedLeaves(task, 1, a, k, b);
  if ((near & nearest.many) != 0) {
    return addManyImages(search, a, k, b, near);
  }
  for (; near != 0; near &= near - 1) {
    const int l = __builtin_ctz(near);
    const int n[3] = {(int)nearest.n[0][l], (int)nearest.n[1][l], (int)nearest.n[2][l]};
    if ((n[0] != 0 || n[1] != 0 || n[2] != 0) &&
        !addImage(search, memberOfNode(task->tree, 1, a, k), memberOfNode(task->tree, 1, b, l), n, nearest.gaps[l])) {
      return false;
    }
  }
  return true;
}

/* Compares members `rows` (bits) of node a, which move, with members `columns` of node b, both open and of one level.
 */
static bool visitLeafImage(const LeafImages* search, int level, int a, int b, unsigned rows, unsigned columns) {
  const LeafTask* task = search->task;
  const BothBoxes boxesA = bothBoxes(task, a);
  const BothBoxes boxesB = bothBoxes(task, b);
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    if (level == 1) {
      if (!addImages(search, a, k, b, columns)) {
        return false;
      }
      continue;
    }
    unsigned near = meetBoth(search, boxesA, k, boxesB) & columns;
    near &= near == 0 ? 0 : comparedLeaves(task, level, a, k, b);
    if (near == 0) {
      continue;
    }
    const int row = memberOfNode(task->tree, level, a, k);
    CT_WIDE(openMembers)(task, level - 1, row);
    for (; near != 0; near &= near - 1) {
      const int l = __builtin_ctz(near);
      const int column = memberOfNode(task->tree, level, b, l);
      CT_WIDE(openMembers)(task, level - 1, column);
      const unsigned nearRows = meetBoth(search, boxesB, l, bothBoxes(task, row)) & movingLeaves(task, row);
      const unsigned nearColumns = meetBoth(search, boxesA, k, bothBoxes(task, column));
      if (!visitLeafImage(search, level - 1, row, column, nearRows, nearColumns)) {
        return false;
      }
    }
  }
  return true;
}

/* ---- Groups ---- */

/* Members of an open node that move. */
typedef struct LeafGroup {
  int level;
  int node;
  unsigned members;
  AxisBoxes before; /* member 0: around all */
  AxisBoxes after;
} LeafGroup;

static LeafGroup leafGroupOf(const LeafTask* task, int level, int node, unsigned members) {
  LeafGroup group = {.level = level, .node = node, .members = members};
  const BothBoxes boxes = bothBoxes(task, node);
  boxGroup(boxes.before, members, &group.before);
  boxGroup(boxes.after, members, &group.after);
  return group;
}

/* Compares a group with an open node of its level or a higher one. False ends the search. */
static bool visitLeafGroup(const LeafImages* search, const LeafGroup* group, int level, int node) {
  const LeafTask* task = search->task;
  unsigned near = meetBoth(search, (BothBoxes){&group->before, &group->after}, 0, bothBoxes(task, node));
  near &= task->leaves->occupied[node];
  if (level == group->level) {
    return near == 0 || visitLeafImage(search, level, group->node, node, group->members, near);
  }
  for (; near != 0; near &= near - 1) {
    const int child = memberOfNode(task->tree, level, node, __builtin_ctz(near));
    CT_WIDE(openMembers)(task, level - 1, child);
    if (!visitLeafGroup(search, group, level - 1, child)) {
      return false;
    }
  }
  return true;
}

/* Compares all that moves in a node of many bodies, which is open, with the scene. */
static bool searchLeafGroups(const LeafImages* search, int level, int node) {
  const LeafTask* task = search->task;
  const unsigned many = level > 1 && task->pieceCount > 0 ? membersOfBody(task, node, MANY_BODIES) : 0;
  const unsigned members = movingLeaves(task, node) & ~many;
  if (members != 0) {
    const LeafGroup group = leafGroupOf(task, level, node, members);
    if (!visitLeafGroup(search, &group, task->tree->levelCount, treeSuperRoot(task->tree))) {
      return false;
    }
  }
  for (unsigned left = many; left != 0; left &= left - 1) {
    if (!searchLeafGroups(search, level - 1, memberOfNode(task->tree, level, node, __builtin_ctz(left)))) {
      return false;
    }
  }
  return true;
}

void CT_WIDE(listLeafImages)(LeafTask* task) {
  /* No shift of near boxes is longer than the size of the state before and in the trial, and the cutoff. */
  const double margin = floatMargin(2 * (task->size + task->cutoff));
  const LeafImages search = {task, latticeOf(&task->sequence->box), (float)(task->cutoff * (1 + 1e-6) + 3 * margin),
                             (float)margin};
  if (task->leaves->occupied[treeSuperRoot(task->tree)] != 0) {
    searchLeafGroups(&search, task->tree->levelCount, treeSuperRoot(task->tree));
  }
}
