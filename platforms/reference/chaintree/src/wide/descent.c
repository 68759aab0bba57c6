/* The descent of the whole tree against itself. */
#include "viewboxes.h"

/* Members of a node that are not of its largest body, if that is the body of its first or last member. In a visit of
 * the node with itself these suffice: every pair of different bodies holds one of them. */
static unsigned ofLesserBodies(const Traversal* t, int node, int count) {
  const unsigned all = (1u << count) - 1;
  const unsigned first = all & ~ofBody(t, node, bodyOfMember(t, node, 0));
  const unsigned last = all & ~ofBody(t, node, bodyOfMember(t, node, count - 1));
  return __builtin_popcount(first) <= __builtin_popcount(last) ? first : last;
}

/* The boxes of the siblings of node b, among which is its own; NULL if that is not thin. */
static const BoxBlock* boxesAround(Traversal* t, const NodePair* pair) {
  if (pair->a == pair->b) {
    return NULL;
  }
  const int parent = treeParent(t->tree, pair->level, pair->b);
  const BoxBlock* boxes = CT_WIDE(boxesInView)(t, pair->level + 1, parent);
  return (boxes->thin >> memberIndex(pair->b) & 1) != 0 ? boxes : NULL;
}

/* In a visit of a node with itself: the members whose pairs with member k of `rows` have been visited. */
static unsigned alreadyVisited(unsigned rows, int k) {
  return rows & ((2u << k) - 1);
}

/* Calls the visit's function for members (bits) of leaf b, with member k of leaf a. False ends the descent. */
CT_NOINLINE bool visitMembers(Traversal* t, const Visit* visit, int a, int k, int b, unsigned mask) {
  mask &= ~ofBody(t, b, bodyOfMember(t, a, k));
  const int partner = mask != 0 ? exclusionPartner(t->exclusions, a, b) : CT_NULL;
  if (partner != CT_NULL) {
    mask &= ~(unsigned)t->exclusions->mask[partner][k];
  }
  for (; mask != 0; mask &= mask - 1) {
    const int i = a * TREE_WIDTH + k;
    const int j = b * TREE_WIDTH + __builtin_ctz(mask);
    if (!visit->function(visit->context, i, j, ctTraversalSquaredDistance(t, i, j))) {
      return false;
    }
  }
  return true;
}

/* Tests these members (bits) of leaf a, which is placed, against all members of leaf b. False ends the descent. */
CT_NOINLINE bool visitLeaves(Traversal* t, Visit* visit, const NodePair* pair, unsigned rows) {
  const int a = pair->a;
  const int b = pair->b;
  const BoxBlock* around = visit->boxes ? boxesAround(t, pair) : NULL;
  if (around != NULL) {
    rows &= nearBox(blockOf(t, a), around, memberIndex(b), visit->reach);
  }
  if (rows == 0) {
    return true;
  }
  placeInView(t, 0, b);
  const Block* blocks[2];
  blocksOf(t, a, b, blocks);
  const int countB = treeMemberCount(t->tree, 0, b);
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    unsigned mask = near16(blocks[1], sphereOf(blocks[0], k), visit->reach);
    visit->particleTests += countB;
    if (a == b) {
      mask &= ~alreadyVisited(rows, k);
    }
    if (mask != 0 && !visitMembers(t, visit, a, k, b, mask)) {
      return false;
    }
  }
  return true;
}

/* Members of `mask`, children of b, whose boxes are out of reach of child k of a. */
static unsigned boxesPart(Visit* visit, int k, unsigned mask, const BoxBlock* a, const BoxBlock* b) {
  visit->pairsBoxed += __builtin_popcount(mask);
  if ((a->thin >> k & 1) == 0) {
    mask &= b->thin;
  }
  if (mask == 0) {
    return 0;
  }
  visit->volumeTests += __builtin_popcount(mask);
  visit->boxTests += __builtin_popcount(mask);
  mask &= boxesApart(a, k, b, visit->reach);
  visit->pairsParted += __builtin_popcount(mask);
  return mask;
}

/* Members of `near`, children of a, whose boxes are within reach of the box of b. */
CT_NOINLINE unsigned nearBoxOf(Traversal* t, const Visit* visit, const NodePair* pair, unsigned near) {
  const BoxBlock* own = CT_WIDE(boxesInView)(t, pair->level, pair->a);
  const BoxBlock* around = boxesAround(t, pair);
  return around != NULL ? near & ~boxesApart(around, memberIndex(pair->b), own, visit->reach) : near;
}

/* Members of `mask`, children of b, whose boxes are within reach of the box of child k of a. */
CT_NOINLINE unsigned nearBoxes(Traversal* t, Visit* visit, const NodePair* pair, int k, unsigned mask) {
  const BoxBlock* a = CT_WIDE(boxesInView)(t, pair->level, pair->a);
  return mask & ~boxesPart(visit, k, mask, a, CT_WIDE(boxesInView)(t, pair->level, pair->b));
}

CT_NOINLINE bool visitChildren(Traversal* t, Visit* visit, const NodePair* pair, unsigned near);

/* Visits two nodes, of which a is placed and has these members (bits) within reach of b. Functions of their own, so
 * that most pairs of nodes, which have no such members, take no more than that test. False ends the descent. */
static inline bool visitNear(Traversal* t, Visit* visit, const NodePair* pair, unsigned near) {
  return near == 0 || (pair->level == 0 ? visitLeaves(t, visit, pair, near) : visitChildren(t, visit, pair, near));
}

static inline void beginVisit(const Traversal* t, Visit* visit) {
  visit->boxes = t->alwaysBoxes || visit->visits >= t->visitsWithoutBoxes;
  visit->visits++;
  visit->visitsWithBoxes += visit->boxes;
}

/* Visits children k of node a and l of node b, which are within reach of each other. False ends the descent. */
static inline bool visitPair(Traversal* t, Visit* visit, const NodePair* parents, int k, int l, NodePair pair) {
  /* Place a mixed node first: its members that are of the other's body drop out. Otherwise one that is placed: then the
   * other may never have to be. Without a branch, which processors would mispredict. */
  const bool bFirst = (t->body[pair.b] < 0) | ((t->placedIn[pair.b] == t->descent) & (t->body[pair.a] >= 0));
  const Sphere sphere = sphereOf(blockOf(t, bFirst ? parents->a : parents->b), bFirst ? k : l);
  pair = (NodePair){pair.level, bFirst ? pair.b : pair.a, bFirst ? pair.a : pair.b};
  placeInView(t, pair.level, pair.a);
  beginVisit(t, visit);
  visit->volumeTests += treeMemberCount(t->tree, pair.level, pair.a);
  unsigned near = near16(blockOf(t, pair.a), sphere, visit->reach);
  if (t->body[pair.a] < 0) {
    near &= ~ofBody(t, pair.a, t->body[pair.b]);
  }
  return visitNear(t, visit, &pair, near);
}

/* Visits all pairs of children of two inner nodes that are within reach; a is placed, and `near` (bits) are its
 * children that are near b and of another body. Leaves out mixed nodes with themselves. False ends the descent. */
CT_NOINLINE bool visitChildren(Traversal* t, Visit* visit, const NodePair* pair, unsigned near) {
  const int below = pair->level - 1;
  int countB;
  const int firstB = treeChildren(t->tree, pair->level, pair->b, &countB);
  const int firstA = firstB + (pair->a - pair->b) * TREE_WIDTH;
  const bool withBoxes = visit->boxes;
  placeInView(t, pair->level, pair->b);
  if (withBoxes) {
    near = nearBoxOf(t, visit, pair, near);
  }
  const Block* blocks[2];
  blocksOf(t, pair->a, pair->b, blocks);
  const unsigned later = pair->a == pair->b ? near : 0;
  const bool isBMixed = t->body[pair->b] < 0;
  unsigned masks[TREE_WIDTH];
  unsigned rows = 0; /* with a mask that is not 0 */
  for (unsigned left = near; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    unsigned mask = near16(blocks[1], sphereOf(blocks[0], k), visit->reach) & ~alreadyVisited(later, k);
    if (isBMixed) {
      mask &= ~ofBody(t, pair->b, bodyOfMember(t, pair->a, k));
    }
    masks[k] = mask;
    rows |= (unsigned)(mask != 0) << k;
  }
  visit->volumeTests += __builtin_popcount(near) * countB;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    unsigned mask = masks[k];
    if (withBoxes) {
      mask = nearBoxes(t, visit, pair, k, mask);
    }
    t->body[firstA + k] = bodyOfMember(t, pair->a, k);
    for (; mask != 0; mask &= mask - 1) {
      const int l = __builtin_ctz(mask);
      t->body[firstB + l] = bodyOfMember(t, pair->b, l);
      if (!visitPair(t, visit, pair, k, l, (NodePair){below, firstA + k, firstB + l})) {
        return false;
      }
    }
  }
  return true;
}

/* Visits a mixed node with itself. False ends the descent. */
static bool visitSelf(Traversal* t, Visit* visit, int level, int node) {
  const NodePair pair = {level, node, node};
  beginVisit(t, visit);
  return visitNear(t, visit, &pair, ofLesserBodies(t, node, treeMemberCount(t->tree, level, node)));
}

/* Climbs to a mixed node, from all such nodes below it: places each in the view, and visits it with itself, unless
 * `visit` is NULL. These nodes hold the joints that turn, and most clashes are near joints. `piece` holds the node's
 * first slot. False ends the descent. */
static bool climb(Traversal* t, Visit* visit, int level, int node, int piece) {
  const View* view = t->view;
  updateWorld(t->world, level, node);
  int end;
  const int begin = treeSlots(t->tree, level, node, &end);
  const int bits = TREE_WIDTH_BITS * level; /* of the width of a member */
  for (int p = piece + 1, done = CT_NULL; level > 0 && p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    const int child = (view->pieces[p].slotBegin - begin) >> bits;
    const bool isMixed = view->pieces[p].slotBegin > begin + (child << bits);
    if (isMixed && child != done) {
      done = child;
      if (!climb(t, visit, level - 1, t->tree->levelBegin[level - 1] + (begin >> bits) + child, p - 1)) {
        return false;
      }
    }
  }
  CT_WIDE(placeMixedNode)(t, level, node, piece);
  return visit == NULL || visitSelf(t, visit, level, node);
}

void CT_WIDE(placeMixedNodes)(Traversal* t) {
  climb(t, NULL, treeTop(t->tree), treeRoot(t->tree), 0);
}

/* Visits all pairs of nodes that may hold a candidate. */
static void descend(Traversal* t, Visit* visit) {
  if (t->view->pieceCount > 1) {
    climb(t, visit, treeTop(t->tree), treeRoot(t->tree), 0);
  }
  if (visit->pairsBoxed > 0) {
    /* Boxes pay: see PAIRS_PER_SEPARATION. */
    const bool pays = PAIRS_PER_SEPARATION * visit->pairsParted > visit->pairsBoxed;
    const int next = pays ? t->visitsWithoutBoxes / 2 : 2 * t->visitsWithoutBoxes + 1;
    t->visitsWithoutBoxes = next < MOST_VISITS_WITHOUT_BOXES ? next : MOST_VISITS_WITHOUT_BOXES;
  }
}

int64_t CT_WIDE(traverse)(Traversal* t, const View* view, CandidateFunction* function, void* context,
                          ctCounts* counts) {
  Visit visit = CT_WIDE(startVisit)(t, view, function, context);
  descend(t, &visit);
  addTests(counts, visit.volumeTests, visit.particleTests);
  return visit.volumeTests + visit.particleTests + COST_OF_BOX_TEST * visit.boxTests +
         COST_OF_BOXES * visit.visitsWithBoxes;
}
