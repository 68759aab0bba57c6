/* Scratch of a descent that needs vectors of sixteen. */
#ifndef CT_DESCENT_H_
#define CT_DESCENT_H_

#include "box.h"
#include "traverse.h"

/* Boxes of an inner node's children. */
typedef struct ChildBoxes {
  BoxBlock own;       /* in the node's frame; made together with the node's own box */
  BoxBlock world;     /* in the world, of the state */
  Revision worldFrom; /* the revision that `world` was built from */
  int movedAt;        /* value of movedBoxesCount when these were last moved */
} ChildBoxes;

/* A search of a view, and its cost. */
typedef struct Visit {
  CandidateFunction* function;
  SureClashFunction* clashes; /* may be NULL */
  void* context;
  float reach;    /* with the margin */
  double margin;  /* for roundings of tests in float */
  bool boxes;     /* this visit tests boxes */
  int64_t visits; /* like all counts here up to the square of the number of nodes */
  int64_t visitsWithBoxes;
  int64_t pairsBoxed;  /* pairs of children whose boxes were compared */
  int64_t pairsParted; /* pairs among these that the boxes separated */
  int64_t boxTests;    /* of the tests of volumes */
  int64_t volumeTests;
  int64_t particleTests;
} Visit;

/* Two nodes of a level. */
typedef struct NodePair {
  int level;
  int a;
  int b;
} NodePair;

/* A node whose members are of different rigid bodies. */
typedef struct MixedNode {
  _Alignas(64) Block block; /* its members in the view */
  int body[TREE_WIDTH];     /* of each member, coded like Traversal.body */
  int node;
  bool isBoxed;
  BoxBlock boxes; /* of the children of an inner node, in the view; made if isBoxed */
} MixedNode;

/* Boxes that a visit reads: of two nodes and of a parent. */
enum { BOXES_PER_VISIT = 3 };

/* The boxes of the children of an inner node that moves, in the view. */
typedef struct MovedBoxes {
  int node;
  uint32_t descent; /* its number */
  BoxBlock boxes;
} MovedBoxes;

/* The code below 0 in Traversal.body. */
static inline int mixedNodeCode(int index) {
  return -1 - index;
}

static inline MixedNode* mixedNodeOf(const Traversal* t, int code) {
  return &t->mixedNodes[-1 - code];
}

#endif /* CT_DESCENT_H_ */
