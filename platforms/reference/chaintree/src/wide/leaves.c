/* Positions of leaves in the world. */
#include "axisboxes.h"

/* Computes the positions of a leaf, by the sums that ctGetPositions makes. */
static void placeLeaf(Leaves* leaves, const Tree* tree, const Sequence* s, int leaf, const Frame* frame,
                      LeafPoints* points) {
  const Leaf* restrict own = &tree->leaf[leaf];
  ctLeafPositions* restrict to = &leaves->state[leaf];
  const Frame f = *frame;
  const double* o = s->worldOrigin;
  double x[3][TREE_WIDTH];
  for (int k = 0; k < TREE_WIDTH; k++) {
    for (int d = 0; d < 3; d++) {
      x[d][k] = f.m[d][0] * own->x[k] + f.m[d][1] * own->y[k] + f.m[d][2] * own->z[k] + f.m[d][3];
    }
  }
  for (int d = 0; d < 3; d++) {
    for (int k = 0; k < TREE_WIDTH; k++) {
      points->x[d][k] = (float)x[d][k];
    }
  }
  for (int k = 0; k < TREE_WIDTH; k++) {
    to->x[k] = x[0][k] + o[0];
    to->y[k] = x[1][k] + o[1];
    to->z[k] = x[2][k] + o[2];
  }
  clearEmpty(to, leaves->occupied[leaf]);
}

/* True if all slots of a node are static. */
static bool isStatic(const LeafUpdate* u, int level, int node) {
  int end;
  const int begin = treeSlots(u->world->tree, level, node, &end);
  for (int p = u->pieceCount - 1; p >= 0; p--) {
    if (u->pieces[p].slotBegin < end) {
      if (u->pieces[p].body != 0) {
        return false;
      }
      end = u->pieces[p].slotBegin;
    }
    if (end <= begin) {
      break;
    }
  }
  return true;
}

/* True if a node has not changed or moved since positions were computed. */
static bool nodeStays(const LeafUpdate* u, int level, int node) {
  if (u->pieceCount > 0) {
    return isStatic(u, level, node);
  }
  const int leafEnd = (node - u->world->tree->levelBegin[level] + 1) << TREE_WIDTH_BITS * level;
  return u->world->tree->contentRevision[node] <= u->leaves->builtFrom && leafEnd <= u->firstMoved;
}

/* Updates a leaf, or the leaves below a node; and its own box, which is member k of its parent. */
static void updateNode(const LeafUpdate* u, int level, int node) {
  Leaves* leaves = u->leaves;
  const Tree* tree = u->world->tree;
  const bool isBoxed = leaves->boxes != NULL && leaves->occupied[node] != 0;
  AxisBoxes* around = isBoxed ? leafBoxes(leaves, tree, treeParent(tree, level, node)) : NULL;
  const int k = memberIndex(node - tree->levelBegin[level]);
  if (level == 0) {
    const Frame frame = ctWorldReadFrame(u->world, node);
    LeafPoints points;
    placeLeaf(leaves, tree, u->sequence, node, &frame, &points);
    if (around != NULL) {
      boxPointsLoosely(&points, leaves->occupied[node], around, k);
      leaves->differs[treeParent(tree, 0, node) - tree->levelBegin[1]] |= (uint16_t)(1u << k);
    }
    return;
  }
  int count;
  const int first = treeChildren(tree, level, node, &count);
  for (int child = first; child < first + count; child++) {
    if (!nodeStays(u, level - 1, child)) {
      updateNode(u, level - 1, child);
    }
  }
  if (around != NULL) {
    boxMembers(leafBoxes(leaves, tree, node), around, k);
  }
}

void CT_WIDE(updateLeaves)(const LeafUpdate* u) {
  updateNode(u, treeTop(u->world->tree), treeRoot(u->world->tree));
}
