/* Pairs of a view with its periodic images. What moves is a few groups of whole members of mixed nodes. Each group is
 * compared with the scene from the root down, until both are of one level; then both descend. */
#include "../images.h"

#include "nearimages.h"
#include "view.h"

/* A search for pairs of the view with its images. */
typedef struct ImageVisit {
  CandidateFunction* function;
  void* context;
  const PeriodicBox* box;
  Lattice lattice;
  float reach; /* with the margin */
  int64_t volumeTests;
  int64_t particleTests;
} ImageVisit;

/* The members (bits) of a node that move as a whole. */
static unsigned movingMembers(const Traversal* t, int node) {
  const int code = t->body[node];
  if (code >= 0) {
    return t->view->allImages || code > 0 ? 0xffff : 0;
  }
  const int* body = mixedNodeOf(t, code)->body;
  unsigned mask = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    mask |= (unsigned)(body[k] > 0) << k;
  }
  return mask;
}

/* Members (bits) of node b that are compared with member k of node a, which moves and is of this body. Where both move,
 * the earlier one is compared with the later one, unless they are of one body that does not turn. */
static unsigned compared(const Traversal* t, int body, int a, int k, int b) {
  unsigned skipped = movingMembers(t, b) & ~membersNotBefore(a, k, b);
  if (!t->view->allImages && keepsDirection(t->view, body)) {
    skipped |= ofBody(t, b, body);
  }
  return ~skipped;
}

/* Places member k of an inner node that is placed, and returns it. */
static int enterMember(Traversal* t, int level, int node, int k) {
  int count;
  const int child = treeChildren(t->tree, level, node, &count) + k;
  t->body[child] = bodyOfMember(t, node, k);
  placeInView(t, level - 1, child);
  return child;
}

/* Calls the function for pairs of slot k of leaf a with slots (bits) of leaf b, in their nearest images. False ends the
 * search. */
static bool visitImageSlots(Traversal* t, const ImageVisit* visit, int a, int k, int b, unsigned mask) {
  const int partner = exclusionPartner(t->exclusions, a, b);
  if (partner != CT_NULL) {
    mask &= ~(unsigned)t->exclusions->mask[partner][k];
  }
  for (; mask != 0; mask &= mask - 1) {
    const int slots[2] = {a * TREE_WIDTH + k, b * TREE_WIDTH + __builtin_ctz(mask)};
    double positions[2][3];
    ctTraversalPosition(t, slots[0], positions[0]);
    ctTraversalPosition(t, slots[1], positions[1]);
    if (!tellNearestImage(t, visit->box, slots, positions, visit->function, visit->context)) {
      return false;
    }
  }
  return true;
}

/* Members (bits) near a sphere, which is shifted; or in any image, if `shift` is NULL. */
static inline unsigned nearMembers(const ImageVisit* visit, const float* shift, float sign, const Block* block,
                                   Sphere sphere) {
  return shift == NULL ? nearImages16(&visit->lattice, block, sphere, visit->reach)
                       : near16(block, shifted(sphere, shift, sign), visit->reach);
}

/* Compares members `rows` (bits) of node a, which move and are shifted, with members `columns` of node b. Both are
 * placed. NULL: in all images; nodes that are small enough to meet in one alone are compared in that. False ends the
 * search. */
static bool visitImage(Traversal* t, ImageVisit* visit, const float* shift, NodePair pair, unsigned rows,
                       unsigned columns) {
  const Block* blocks[2];
  blocksOf(t, pair.a, pair.b, blocks);
  const int count = treeMemberCount(t->tree, pair.level, pair.b);
  unsigned masks[TREE_WIDTH];
  *(pair.level > 0 ? &visit->volumeTests : &visit->particleTests) += __builtin_popcount(rows) * count;
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const unsigned near = nearMembers(visit, shift, 1, blocks[1], sphereOf(blocks[0], k)) & columns;
    masks[k] = near == 0 ? 0 : near & compared(t, bodyOfMember(t, pair.a, k), pair.a, k, pair.b);
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
      const Sphere aroundA = sphereOf(blockOf(t, pair.a), k);
      const Sphere aroundB = sphereOf(blockOf(t, pair.b), l);
      const float* below = shift;
      float own[3];
      if (shift == NULL && haveOneImage(&visit->lattice, aroundA.r + aroundB.r + visit->reach)) {
        if (!shiftOf(&visit->lattice, visit->box, aroundA, aroundB, own)) {
          continue;
        }
        below = own;
      }
      const unsigned near[2] = {nearMembers(visit, below, -1, blockOf(t, a), aroundB),
                                nearMembers(visit, below, 1, blockOf(t, b), aroundA)};
      if (!visitImage(t, visit, below, (NodePair){pair.level - 1, a, b}, near[0], near[1])) {
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

/* A sphere around members (bits) of a placed node. */
static Sphere sphereAround(Traversal* t, int node, unsigned members) {
  Block block = *blockOf(t, node);
  store16(block.r, blend16(members, all16(-INFINITY), load16(block.r)));
  return sphereAroundBlock(&block);
}

/* Members of a node that move, each of one body. */
typedef struct Group {
  int level;
  int node;
  unsigned members;
  Sphere around;
} Group;

/* Compares a group with a placed node of its level or a higher one. False ends the search. */
static bool visitGroup(Traversal* t, ImageVisit* visit, const Group* group, int level, int node) {
  unsigned near = nearImages16(&visit->lattice, blockOf(t, node), group->around, visit->reach);
  visit->volumeTests += treeMemberCount(t->tree, level, node);
  if (level == group->level) {
    return near == 0 || visitImage(t, visit, NULL, (NodePair){level, group->node, node}, group->members, near);
  }
  for (; near != 0; near &= near - 1) {
    if (!visitGroup(t, visit, group, level - 1, enterMember(t, level, node, __builtin_ctz(near)))) {
      return false;
    }
  }
  return true;
}

/* Compares members (bits) of a node, which move, with the scene. False ends the search. */
static bool visitMoving(Traversal* t, ImageVisit* visit, int node, unsigned members) {
  const Group group = {levelOf(t->tree, node), node, members, sphereAround(t, node, members)};
  return visitGroup(t, visit, &group, treeTop(t->tree), treeRoot(t->tree));
}

int64_t CT_WIDE(traverseImages)(Traversal* t, const View* view, const PeriodicBox* box, bool isPlaced,
                                CandidateFunction* function, void* context, ctCounts* counts) {
  const int root = treeRoot(t->tree);
  ImageVisit visit = {.function = function, .context = context, .box = box, .lattice = latticeOf(box)};
  if (!isPlaced) {
    CT_WIDE(startView)(t, view);
  }
  visit.reach = (float)imageReach(t);
  if (view->pieceCount == 1) {
    t->body[root] = view->pieces[0].body;
    placeInView(t, treeTop(t->tree), root);
    visitMoving(t, &visit, root, 0xffff);
  } else {
    if (!isPlaced) {
      CT_WIDE(placeMixedNodes)(t);
    }
    for (int i = 0; i < t->mixedNodeCount; i++) {
      const int node = t->mixedNodes[i].node;
      const unsigned members = movingMembers(t, node);
      if (members != 0 && !visitMoving(t, &visit, node, members)) {
        break;
      }
    }
  }
  addTests(counts, visit.volumeTests, visit.particleTests);
  return visit.volumeTests + visit.particleTests;
}
