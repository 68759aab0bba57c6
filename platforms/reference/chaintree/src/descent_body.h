/* The descent of the whole tree against itself, compiled once for each instruction set by the file that includes
 * this. */
#ifndef CT_DESCENT_BODY_H_
#define CT_DESCENT_BODY_H_

#include "viewboxes_body.h"

/* Begins a descent: expands the root and all straddlers. */
static void expandRoot(Traversal* t) {
  const View* view = t->view;
  const int root = treeRoot(t->tree);
  if (view->pieceCount > 1) {
    expandStraddler(t, treeTop(t->tree), root, 0);
  } else {
    t->motion[root] = view->pieces[0].body;
    expand(t, treeTop(t->tree), root);
  }
}

/* Members of a node that are not of its largest body, as far as that is the body of its first or last member. In a
 * visit of the node with itself these suffice: every pair of different bodies holds one of them. */
static unsigned ofLesserBodies(const Traversal* t, int node, int count) {
  const unsigned all = (1u << count) - 1;
  const unsigned first = all & ~ofBody(t, node, motionOfMember(t, node, 0));
  const unsigned last = all & ~ofBody(t, node, motionOfMember(t, node, count - 1));
  return __builtin_popcount(first) <= __builtin_popcount(last) ? first : last;
}

/* Members of node a that are near the volume of node b and of another body, as bits. If a is b, those that suffice for
 * a visit of a node with itself. */
static unsigned nearNode(Traversal* t, Visit* visit, int count, const NodePair* pair) {
  if (pair->a == pair->b) {
    return ofLesserBodies(t, pair->a, count);
  }
  visit->volumeTests += count;
  const Block* around = blockOf(t, treeParent(t->tree, pair->level, pair->b));
  const Sphere sphere = sphereOf(around, pair->b % TREE_WIDTH);
  return near16(blockOf(t, pair->a), sphere, visit->reach) & ~ofBody(t, pair->a, t->motion[pair->b]);
}

/* The boxes of the siblings of node b, among which is its own; NULL if that is not thin. */
static const BoxBlock* boxesAround(Traversal* t, const NodePair* pair) {
  if (pair->a == pair->b) {
    return NULL;
  }
  const int parent = treeParent(t->tree, pair->level, pair->b);
  const BoxBlock* boxes = boxesInView(t, pair->level + 1, parent);
  return (boxes->thin >> pair->b % TREE_WIDTH & 1) != 0 ? boxes : NULL;
}

/* In a visit of a node with itself: the members whose pairs with member k of `rows` have been visited. */
static unsigned alreadyVisited(unsigned rows, int k) {
  return rows & ((2u << k) - 1);
}

/* Tests these members (bits) of leaf a, which is expanded, against all members of leaf b. False ends the descent. */
static bool testMembers(Traversal* t, Visit* visit, int a, int b, unsigned rows) {
  int endB;
  const int beginB = treeSlots(t->tree, 0, b, &endB);
  expand(t, 0, b);
  const Block* blocks[2];
  blocksOf(t, a, b, blocks);
  const int partner = exclusionPartner(t->exclusions, a, b);
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const int i = a * TREE_WIDTH + k;
    unsigned mask = near16(blocks[1], sphereOf(blocks[0], k), visit->reach);
    visit->particleTests += endB - beginB;
    if (a == b) {
      mask &= ~alreadyVisited(rows, k);
    }
    if (mask != 0) {
      mask &= ~ofBody(t, b, motionOfMember(t, a, k));
    }
    if (partner != CT_NULL) {
      mask &= ~(unsigned)t->exclusions->mask[partner][k];
    }
    for (; mask != 0; mask &= mask - 1) {
      const int j = beginB + __builtin_ctz(mask);
      if (!visit->function(visit->context, i, j, ctTraversalSquaredDistance(t, i, j))) {
        return false;
      }
    }
  }
  return true;
}

/* Tests the particles of two leaves. False ends the descent. */
static bool visitLeaves(Traversal* t, Visit* visit, const NodePair* pair) {
  int endA;
  const int beginA = treeSlots(t->tree, 0, pair->a, &endA);
  unsigned near = nearNode(t, visit, endA - beginA, pair);
  const BoxBlock* around = visit->boxes && near != 0 ? boxesAround(t, pair) : NULL;
  if (around != NULL) {
    near &= nearBox(blockOf(t, pair->a), around, pair->b % TREE_WIDTH, visit->reach);
  }
  return near == 0 || testMembers(t, visit, pair->a, pair->b, near);
}

/* Those in `mask`, children of b, whose boxes are out of reach of child k of a. */
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

/* Puts the pairs of children of two inner nodes that are within reach on the stack. */
static void visitInnerNodes(Traversal* t, Visit* visit, const NodePair* pair, int* depth) {
  const int below = pair->level - 1;
  int countA;
  int countB;
  const int firstA = treeChildren(t->tree, pair->level, pair->a, &countA);
  const int firstB = treeChildren(t->tree, pair->level, pair->b, &countB);
  unsigned near = nearNode(t, visit, countA, pair);
  if (near == 0) {
    return;
  }
  expand(t, pair->level, pair->b);
  const Block* blocks[2];
  blocksOf(t, pair->a, pair->b, blocks);
  const BoxBlock* boxes[2] = {NULL, NULL};
  if (visit->boxes) {
    boxes[0] = boxesInView(t, pair->level, pair->a);
    boxes[1] = boxesInView(t, pair->level, pair->b);
    const BoxBlock* around = boxesAround(t, pair);
    if (around != NULL) {
      near &= ~boxesApart(around, pair->b % TREE_WIDTH, boxes[0], visit->reach);
    }
  }
  unsigned straddling = 0;
  for (unsigned left = near; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const int i = firstA + k;
    const int motion = motionOfMember(t, pair->a, k);
    t->motion[i] = motion;
    unsigned mask = near16(blocks[1], sphereOf(blocks[0], k), visit->reach);
    visit->volumeTests += countB;
    if (pair->a == pair->b) {
      mask &= ~alreadyVisited(near, k);
    }
    if (mask != 0) {
      mask &= ~ofBody(t, pair->b, motion);
    }
    if (mask != 0 && visit->boxes) {
      mask &= ~boxesPart(visit, k, mask, boxes[0], boxes[1]);
    }
    for (; mask != 0; mask &= mask - 1) {
      const int l = __builtin_ctz(mask);
      t->motion[firstB + l] = motionOfMember(t, pair->b, l);
      t->stack[(*depth)++] = (NodePair){below, i, firstB + l};
    }
    straddling |= (unsigned)(pair->a == pair->b && blocks[0]->r[k] >= 0 && motion < 0) << k;
  }
  /* Visit straddlers first: they hold the joints that turn, and most clashes are near those. */
  for (; straddling != 0; straddling &= straddling - 1) {
    const int i = firstA + __builtin_ctz(straddling);
    t->stack[(*depth)++] = (NodePair){below, i, i};
  }
}

/* Visits all pairs of nodes that may hold a candidate. */
static void descend(Traversal* t, Visit* visit) {
  const int root = treeRoot(t->tree);
  expandRoot(t);
  int depth = 0;
  if (t->motion[root] < 0) {
    t->stack[depth++] = (NodePair){treeTop(t->tree), root, root};
  }
  bool goesOn = true;
  for (int visits = 0; goesOn && depth > 0; visits++) {
    NodePair pair = t->stack[--depth];
    /* Take as a the one that straddles: its members that are of b's body drop out. Otherwise one that is expanded: then
     * b may never have to be. Without a branch, which processors would mispredict. */
    const bool bFirst = (t->motion[pair.b] < 0) | ((t->nodeStamp[pair.b] == t->stamp) & (t->motion[pair.a] >= 0));
    pair = (NodePair){pair.level, bFirst ? pair.b : pair.a, bFirst ? pair.a : pair.b};
    expand(t, pair.level, pair.a);
    visit->boxes = t->alwaysBoxes || visits >= t->visitsWithoutBoxes;
    visit->visitsWithBoxes += visit->boxes;
    if (pair.level == 0) {
      goesOn = visitLeaves(t, visit, &pair);
    } else {
      visitInnerNodes(t, visit, &pair, &depth);
    }
  }
  if (visit->pairsBoxed > 0) {
    /* More than one in PAIRS_A_SEPARATION. */
    const bool pays = PAIRS_A_SEPARATION * visit->pairsParted > visit->pairsBoxed;
    const int next = pays ? t->visitsWithoutBoxes / 2 : 2 * t->visitsWithoutBoxes + 1;
    t->visitsWithoutBoxes = next < MOST_VISITS_WITHOUT_BOXES ? next : MOST_VISITS_WITHOUT_BOXES;
  }
}

#endif /* CT_DESCENT_BODY_H_ */
