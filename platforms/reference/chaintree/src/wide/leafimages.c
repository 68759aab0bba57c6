/* Pairs of leaves with periodic images. What moves is a few groups of members, as in images.c; in the state everything
 * counts as moving. An image of each group that is near is searched for from the root down, until both are of one
 * level; then both descend. Of two opposite images, both are searched for pairs of what moves with what does not, and
 * the first alone for pairs of which both move. */
#include "leafimages.h"

#include <stdlib.h>

#include "axisboxes.h"
#include "boxdescent.h"

/* A search for pairs of an image with the scene. */
typedef struct LeafImages {
  LeafTask* task;
  bool isFirst; /* of two opposite images */
  int n[3];
  float shift[3];
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

/* Members that do not move, or hold leaves that do not. */
static unsigned holdingStatic(const LeafTask* task, int level, int node) {
  if (task->pieceCount == 0) {
    return 0;
  }
  return membersOfBody(task, node, 0) | (level > 1 ? membersOfBody(task, node, MANY_BODIES) : 0);
}

/* Members of node b whose pairs with an image of member k of node a are searched: unless both are of one body that does
 * not turn, and so keeps its distances to its own images. */
static unsigned searchedLeaves(const LeafImages* search, int level, int a, int k, int b) {
  const LeafTask* task = search->task;
  if (!search->isFirst) {
    return holdingStatic(task, level, b);
  }
  const unsigned occupied = task->leaves->occupied[b];
  if (task->pieceCount == 0) {
    return occupied;
  }
  const int body = trialMembers(task->leaves, task->tree, a)->body[k];
  return body != MANY_BODIES && isTranslation(&task->motions[body]) ? occupied & ~membersOfBody(task, b, body)
                                                                    : occupied;
}

/* ---- Gaps ---- */

/* Squared gaps between member k of some boxes, shifted in this direction, and sixteen others. */
CT_INLINE Float16 shiftedGaps(const LeafImages* search, float sign, const AxisBoxes* row, int k,
                              const AxisBoxes* others) {
  Float16 gap[3];
  for (int d = 0; d < 3; d++) {
    const float low = row->low[d][k] + sign * search->shift[d] - search->margin;
    const float high = row->high[d][k] + sign * search->shift[d] + search->margin;
    const Float16 below = sub16(load16(others->low[d]), all16(high));
    const Float16 above = sub16(all16(low), load16(others->high[d]));
    gap[d] = max16(max16(below, above), all16(0));
  }
  return squared16(gap[0], gap[1], gap[2]);
}

/* The members (bits) of `others` that are near, before the trial or in it. Writes the least squared gaps. */
CT_INLINE unsigned nearShifted(const LeafImages* search, float sign, BothBoxes row, int k, BothBoxes others,
                               float gaps[TREE_WIDTH]) {
  Float16 least = shiftedGaps(search, sign, row.before, k, others.before);
  if (row.after != row.before || others.after != others.before) {
    least = min16(least, shiftedGaps(search, sign, row.after, k, others.after));
  }
  search->task->tests += TREE_WIDTH;
  store16(gaps, least);
  return ~greater16(least, all16(search->task->limit)) & 0xffff;
}

/* ---- Pairs ---- */

/* Adds the pairs of a shifted leaf with leaves first + l for each bit l. */
static bool addImages(const LeafImages* search, int leaf, int first, unsigned near, const float gaps[TREE_WIDTH]) {
  LeafPairs* pairs = search->task->pairs;
  if (!ctLeafPairsReserve(pairs, pairs->count + TREE_WIDTH)) {
    search->task->failed = true;
    return false;
  }
  for (; near != 0; near &= near - 1) {
    const int l = __builtin_ctz(near);
    const bool isLower = leaf <= first + l;
    ctLeafPair* pair = &pairs->pairs[pairs->count++];
    pair->a = isLower ? leaf : first + l;
    pair->b = isLower ? first + l : leaf;
    pair->squaredGap = gaps[l];
    for (int d = 0; d < 3; d++) {
      pair->image[d] = isLower ? search->n[d] : -search->n[d];
    }
  }
  return true;
}

/* Searches an image of members `rows` (bits) of node a and members `columns` of node b, both open and of one level. */
static bool visitLeafImage(const LeafImages* search, int level, int a, int b, unsigned rows, unsigned columns) {
  const LeafTask* task = search->task;
  const BothBoxes boxesA = bothBoxes(task, a);
  const BothBoxes boxesB = bothBoxes(task, b);
  float gaps[TREE_WIDTH];
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const int row = memberOfNode(task->tree, level, a, k);
    unsigned near = nearShifted(search, 1, boxesA, k, boxesB, gaps) & columns;
    near &= near == 0 ? 0 : searchedLeaves(search, level, a, k, b);
    if (near == 0) {
      continue;
    }
    if (level == 1) {
      if (!addImages(search, row, memberOfNode(task->tree, level, b, 0), near, gaps)) {
        return false;
      }
      continue;
    }
    CT_WIDE(openMembers)(task, level - 1, row);
    for (; near != 0; near &= near - 1) {
      const int l = __builtin_ctz(near);
      const int column = memberOfNode(task->tree, level, b, l);
      CT_WIDE(openMembers)(task, level - 1, column);
      const unsigned nearRows = nearShifted(search, -1, boxesB, l, bothBoxes(task, row), gaps);
      const unsigned nearColumns = nearShifted(search, 1, boxesA, k, bothBoxes(task, column), gaps);
      if (!visitLeafImage(search, level - 1, row, column, nearRows & movingLeaves(task, row), nearColumns)) {
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

static void boxGroup(const AxisBoxes* from, unsigned members, AxisBoxes* around) {
  AxisBoxes kept = *from;
  for (int d = 0; d < 3; d++) {
    store16(kept.low[d], blend16(members, all16(INFINITY), load16(kept.low[d])));
    store16(kept.high[d], blend16(members, all16(-INFINITY), load16(kept.high[d])));
  }
  clearAxisBoxes(around);
  boxMembers(&kept, around, 0);
}

static LeafGroup leafGroupOf(const LeafTask* task, int level, int node, unsigned members) {
  LeafGroup group = {.level = level, .node = node, .members = members};
  const BothBoxes boxes = bothBoxes(task, node);
  boxGroup(boxes.before, members, &group.before);
  boxGroup(boxes.after, members, &group.after);
  return group;
}

/* Writes the box around member 0 before the trial and in it. */
static void boundBoth(const AxisBoxes* before, const AxisBoxes* after, double low[3], double high[3]) {
  for (int d = 0; d < 3; d++) {
    low[d] = lesser((double)before->low[d][0], (double)after->low[d][0]);
    high[d] = larger((double)before->high[d][0], (double)after->high[d][0]);
  }
}

/* Searches an image of a group and an open node of its level or a higher one. False ends the search. */
static bool visitLeafGroup(const LeafImages* search, const LeafGroup* group, int level, int node) {
  const LeafTask* task = search->task;
  float gaps[TREE_WIDTH];
  unsigned near = nearShifted(search, 1, (BothBoxes){&group->before, &group->after}, 0, bothBoxes(task, node), gaps);
  near &= search->isFirst ? task->leaves->occupied[node] : holdingStatic(task, level, node);
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

/* Searches one image. */
static bool searchLeafImage(LeafTask* task, const Image* image, const LeafGroup* group, int level, int node) {
  LeafImages search = {.task = task, .isFirst = isFirstOfOpposite(image->n)};
  if (!search.isFirst && task->pieceCount == 0) {
    return true;
  }
  for (int d = 0; d < 3; d++) {
    if (abs(image->n[d]) > CT_MOST_IMAGE) {
      task->isTooLong = true;
      return false;
    }
    search.n[d] = image->n[d];
    search.shift[d] = (float)image->shift[d];
  }
  const double length = sqrt(dot(image->shift, image->shift));
  search.margin = (float)floatMargin(task->size + task->cutoff + length);
  return visitLeafGroup(&search, group, level, node);
}

/* Searches all images of a group that are near an open node, of its level or a higher one. */
static bool searchLeafImages(LeafTask* task, const LeafGroup* group, int level, int node) {
  const unsigned occupied = task->leaves->occupied[node];
  const LeafGroup other = leafGroupOf(task, level, node, occupied);
  double lowA[3];
  double highA[3];
  double lowB[3];
  double highB[3];
  boundBoth(&group->before, &group->after, lowA, highA);
  boundBoth(&other.before, &other.after, lowB, highB);
  /* No shift is longer than the sum of both boxes' sizes and the cutoff. */
  const double reach = task->cutoff * (1 + 1e-6) + floatMargin(4 * (task->size + task->cutoff));
  ImageRange range = ctImageRange(&task->sequence->box, lowA, highA, lowB, highB, reach);
  const ImageRange all = range;
  int count = 0;
  while (count <= MOST_IMAGES && ctNextImage(&range)) {
    count++;
  }
  if (count > MOST_IMAGES && level > group->level) {
    for (unsigned left = occupied; left != 0; left &= left - 1) {
      const int child = memberOfNode(task->tree, level, node, __builtin_ctz(left));
      CT_WIDE(openMembers)(task, level - 1, child);
      if (!searchLeafImages(task, group, level - 1, child)) {
        return false;
      }
    }
    return true;
  }
  if (count > MOST_IMAGES && level > 1) {
    for (unsigned left = group->members; left != 0; left &= left - 1) {
      const int child = memberOfNode(task->tree, level, group->node, __builtin_ctz(left));
      CT_WIDE(openMembers)(task, level - 1, child);
      const LeafGroup below = leafGroupOf(task, level - 1, child, movingLeaves(task, child));
      if (!searchLeafImages(task, &below, level, node)) {
        return false;
      }
    }
    return true;
  }
  for (range = all; ctNextImage(&range);) {
    if (!searchLeafImage(task, &range.image, group, level, node)) {
      return false;
    }
  }
  return true;
}

/* Searches all images of what moves in a node of many bodies, which is open. */
static bool searchLeafGroups(LeafTask* task, int level, int node) {
  const int superRoot = treeSuperRoot(task->tree);
  const unsigned many = level > 1 && task->pieceCount > 0 ? membersOfBody(task, node, MANY_BODIES) : 0;
  const unsigned members = movingLeaves(task, node) & ~many;
  if (members != 0) {
    const LeafGroup group = leafGroupOf(task, level, node, members);
    if (!searchLeafImages(task, &group, task->tree->levelCount, superRoot)) {
      return false;
    }
  }
  for (unsigned left = many; left != 0; left &= left - 1) {
    if (!searchLeafGroups(task, level - 1, memberOfNode(task->tree, level, node, __builtin_ctz(left)))) {
      return false;
    }
  }
  return true;
}

void CT_WIDE(listLeafImages)(LeafTask* task) {
  if (task->leaves->occupied[treeSuperRoot(task->tree)] != 0) {
    searchLeafGroups(task, task->tree->levelCount, treeSuperRoot(task->tree));
  }
}
