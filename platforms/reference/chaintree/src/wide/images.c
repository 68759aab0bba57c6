/* Pairs of a view with its periodic images. What moves is a few groups of whole members of mixed nodes. An image of
 * each group that is near the view is searched for from the root down, until both are of one level; then both descend.
 */
#include "../images.h"

#include "view.h"

/* A search for pairs of an image with the view. */
typedef struct ImageVisit {
  CandidateFunction* function;
  void* context;
  const PeriodicBox* box;
  bool isFirst; /* of two opposite images: of these, only the first is searched for pairs of which both slots move */
  float shift[3];
  float reach; /* with the margin */
  int64_t volumeTests;
  int64_t particleTests;
} ImageVisit;

/* The members of a node that do not move, or of which a part does not. */
static unsigned notMoving(const Traversal* t, int node) {
  const int code = t->body[node];
  if (t->view->allImages) {
    return 0;
  }
  if (code >= 0) {
    return code == 0 ? 0xffff : 0;
  }
  const int* body = mixedNodeOf(t, code)->body;
  unsigned mask = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    mask |= (unsigned)(body[k] <= 0) << k;
  }
  return mask;
}

/* Members of node b (bits) of which an image of a member of this body is searched: what moves against what does not,
 * and against what moves too, unless that is the same body and does not turn. */
static unsigned searched(const Traversal* t, const ImageVisit* visit, int body, int b) {
  if (!visit->isFirst) {
    return notMoving(t, b);
  }
  if (t->view->allImages) {
    return ~0u;
  }
  return body > 0 && keepsDirection(t->view, body) ? ~ofBody(t, b, body) : ~0u;
}

/* Places member k of an inner node that is placed, and returns it. */
static int enterMember(Traversal* t, int level, int node, int k) {
  int count;
  const int child = treeChildren(t->tree, level, node, &count) + k;
  t->body[child] = bodyOfMember(t, node, k);
  placeInView(t, level - 1, child);
  return child;
}

/* Calls the function for pairs of slot k of leaf a, shifted, with slots (bits) of leaf b. False ends the search. */
static bool visitImageSlots(Traversal* t, const ImageVisit* visit, int a, int k, int b, unsigned mask) {
  const int partner = exclusionPartner(t->exclusions, a, b);
  if (partner != CT_NULL) {
    mask &= ~(unsigned)t->exclusions->mask[partner][k];
  }
  double x[3];
  double y[3];
  const int slotA = a * TREE_WIDTH + k;
  for (; mask != 0; mask &= mask - 1) {
    const int slotB = b * TREE_WIDTH + __builtin_ctz(mask);
    ctTraversalPosition(t, slotA, x);
    ctTraversalPosition(t, slotB, y);
    if (!visit->function(visit->context, slotA, slotB, squaredImageDistance(x, y, t->image))) {
      return false;
    }
  }
  return true;
}

/* Searches an image of members `rows` (bits) of node a and node b, of which `columns` are near. Both are placed. False
 * ends the search. */
static bool visitImage(Traversal* t, ImageVisit* visit, NodePair pair, unsigned rows, unsigned columns) {
  const Block* blocks[2];
  blocksOf(t, pair.a, pair.b, blocks);
  const int count = treeMemberCount(t->tree, pair.level, pair.b);
  unsigned masks[TREE_WIDTH];
  *(pair.level > 0 ? &visit->volumeTests : &visit->particleTests) += __builtin_popcount(rows) * count;
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const unsigned near = near16(blocks[1], shifted(sphereOf(blocks[0], k), visit->shift, 1), visit->reach);
    masks[k] = near & columns & searched(t, visit, bodyOfMember(t, pair.a, k), pair.b);
    rows &= ~((unsigned)(masks[k] == 0) << k);
  }
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    if (pair.level == 0) {
      if (!visitImageSlots(t, visit, pair.a, k, pair.b, masks[k])) {
        return false;
      }
      continue;
    }
    const int a = enterMember(t, pair.level, pair.a, k);
    for (; masks[k] != 0; masks[k] &= masks[k] - 1) {
      const int l = __builtin_ctz(masks[k]);
      const int b = enterMember(t, pair.level, pair.b, l);
      const Sphere aroundA = shifted(sphereOf(blockOf(t, pair.a), k), visit->shift, 1);
      const Sphere aroundB = shifted(sphereOf(blockOf(t, pair.b), l), visit->shift, -1);
      const unsigned near[2] = {near16(blockOf(t, a), aroundB, visit->reach),
                                near16(blockOf(t, b), aroundA, visit->reach)};
      if (!visitImage(t, visit, (NodePair){pair.level - 1, a, b}, near[0], near[1])) {
        return false;
      }
    }
  }
  return true;
}

static int levelOf(const Tree* tree, int node) {
  int level = 0;
  while (node >= tree->levelBegin[level + 1]) {
    level++;
  }
  return level;
}

/* Members of a node that move, each of one body. */
typedef struct Group {
  int level;
  int node;
  unsigned members;
  double low[3]; /* of the box around them */
  double high[3];
  Sphere around;
} Group;

static Group groupOf(Traversal* t, int level, int node, unsigned members) {
  Group group = {.level = level, .node = node, .members = members};
  Block block = *blockOf(t, node);
  store16(block.r, blend16(members, all16(-INFINITY), load16(block.r)));
  boundsOfBlock(&block, group.low, group.high);
  group.around = middleOfBlock(&block);
  group.around.r += radiusAbout(group.around, &block, block.r) * (1 + 1e-6f);
  return group;
}

/* Searches an image of a group and a placed node of its level or a higher one. False ends the search. */
static bool visitGroup(Traversal* t, ImageVisit* visit, const Group* group, int level, int node) {
  unsigned near = near16(blockOf(t, node), shifted(group->around, visit->shift, 1), visit->reach);
  near &= visit->isFirst ? ~0u : notMoving(t, node);
  visit->volumeTests += treeMemberCount(t->tree, level, node);
  if (level == group->level) {
    return near == 0 || visitImage(t, visit, (NodePair){level, group->node, node}, group->members, near);
  }
  for (; near != 0; near &= near - 1) {
    if (!visitGroup(t, visit, group, level - 1, enterMember(t, level, node, __builtin_ctz(near)))) {
      return false;
    }
  }
  return true;
}

/* Searches all images of a group that are near a placed node, of its level or a higher one. False ends the search. */
static bool visitImages(Traversal* t, ImageVisit* visit, const Group* group, int level, int node) {
  double low[3];
  double high[3];
  boundsOfBlock(blockOf(t, node), low, high);
  ImageRange range = ctImageRange(visit->box, group->low, group->high, low, high, imageReach(t));
  const ImageRange all = range;
  int count = 0;
  while (count <= MOST_IMAGES && ctNextImage(&range)) {
    count++;
  }
  if (count > MOST_IMAGES && level > group->level) {
    for (int k = 0; k < treeMemberCount(t->tree, level, node); k++) {
      if (!visitImages(t, visit, group, level - 1, enterMember(t, level, node, k))) {
        return false;
      }
    }
    return true;
  }
  if (count > MOST_IMAGES && level > 0) {
    for (unsigned left = group->members; left != 0; left &= left - 1) {
      const int child = enterMember(t, level, group->node, __builtin_ctz(left));
      const Group below = groupOf(t, level - 1, child, 0xffff);
      if (!visitImages(t, visit, &below, level, node)) {
        return false;
      }
    }
    return true;
  }
  for (range = all; ctNextImage(&range);) {
    t->image = &range.image;
    visit->isFirst = isFirstOfOpposite(range.image.n);
    for (int d = 0; d < 3; d++) {
      visit->shift[d] = (float)range.image.shift[d];
    }
    visit->reach = (float)(t->view->reach + imageMargin(t, range.image.shift));
    if (!visitGroup(t, visit, group, level, node)) {
      return false;
    }
  }
  return true;
}

/* The members of a mixed node that move, each of one body. */
static unsigned movingMembers(const MixedNode* node) {
  unsigned mask = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    mask |= (unsigned)(node->body[k] > 0) << k;
  }
  return mask;
}

/* Searches all images of all that moves. All mixed nodes are placed. */
static void visitAllGroups(Traversal* t, ImageVisit* visit) {
  for (int i = 0; i < t->mixedNodeCount; i++) {
    const MixedNode* mixed = &t->mixedNodes[i];
    const unsigned members = movingMembers(mixed);
    if (members == 0) {
      continue;
    }
    const Group group = groupOf(t, levelOf(t->tree, mixed->node), mixed->node, members);
    if (!visitImages(t, visit, &group, treeTop(t->tree), treeRoot(t->tree))) {
      return;
    }
  }
}

int64_t CT_WIDE(traverseImages)(Traversal* t, const View* view, const PeriodicBox* box, CandidateFunction* function,
                                void* context, ctCounts* counts) {
  const int top = treeTop(t->tree);
  const int root = treeRoot(t->tree);
  ImageVisit visit = {.function = function, .context = context, .box = box};
  CT_WIDE(startView)(t, view);
  if (view->pieceCount == 1) {
    t->body[root] = view->pieces[0].body;
    placeInView(t, top, root);
    const Group whole = groupOf(t, top, root, 0xffff);
    visitImages(t, &visit, &whole, top, root);
  } else {
    CT_WIDE(placeMixedNodes)(t);
    visitAllGroups(t, &visit);
  }
  addTests(counts, visit.volumeTests, visit.particleTests);
  return visit.volumeTests + visit.particleTests;
}
