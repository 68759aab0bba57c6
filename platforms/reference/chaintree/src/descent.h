/* Scratch of a descent, in sixteens. */
#ifndef CT_DESCENT_H_
#define CT_DESCENT_H_

#include "box.h"
#include "traverse.h"

/* Traversal.visitsWithoutBoxes is no more than this. */
enum { MOST_VISITS_WITHOUT_BOXES = 1 << 20 };

/* Slots in a row that move while all else is at rest: up to so many go against that one by one. */
enum { MOST_MOVERS = 2 * TREE_WIDTH };

/* Boxes of a node's children. */
typedef struct NodeBoxes {
  BoxBlock own;      /* in the node's frame; made with the node's own box */
  BoxBlock rest;     /* in the world as the state has them */
  int64_t ownTime;   /* the tree's when `own` was made, or NEVER */
  int64_t restSince; /* of the node when `rest` was made */
  int movedAt;       /* how many others had been moved before in the descent in which these last were */
} NodeBoxes;

/* What a descent looks for, and what it has cost. */
typedef struct Visit {
  CandidateFunction* function;
  void* context;
  float reach;
  bool boxes; /* are to be looked at */
  int visitsWithBoxes;
  int pairsBoxed;
  int pairsParted;
  int64_t boxTests; /* of the tests of volumes */
  int64_t volumeTests;
  int64_t particleTests;
} Visit;

/* An item whose members are of different rigid bodies. */
typedef struct Straddler {
  int item;
  Block block;            /* its members as they lie in the view */
  int motion[TREE_WIDTH]; /* of each member, coded like Traversal.motion */
  bool isBoxed;
  BoxBlock boxes; /* of the members of a node, in the view */
} Straddler;

/* A visit looks at those of two nodes and of a parent. */
enum { BOXES_OF_A_VISIT = 3 };

/* The boxes of a node that moves, in the view. */
typedef struct MovedBoxes {
  int node;
  uint32_t stamp; /* of the descent */
  BoxBlock boxes;
} MovedBoxes;

/* The code below Traversal.motion < 0. */
static inline int straddlerCode(int index) {
  return -1 - index;
}

static inline Straddler* straddlerOf(const Traversal* t, int code) {
  return &t->straddlers[-1 - code];
}

#endif /* CT_DESCENT_H_ */
