/* The descent over boxes along the world's axes: finds the near nodes of a level. */
#ifndef CT_BOX_DESCENT_H_
#define CT_BOX_DESCENT_H_

#include "set.h"

/* For the functions below. A compiler that optimizes little does not see that their pointers are constants, and refuses
 * to inline them: so the build says where that is sure. */
#ifdef CT_INLINES_VISITORS
#define CT_VISITOR CT_INLINE
#else
#define CT_VISITOR static inline
#endif

/* Returns the members (bits) of node a that may be near a member of node b. */
typedef unsigned RowsFunction(void* search, int level, int a, int b);

/* Returns the members (bits) of node b that are near member k of node a, each pair of members once. */
typedef unsigned ColumnsFunction(void* search, int level, int a, int k, int b);

/* Receives a node and, as bits, members of another that are near it; `first` is member 0. False ends the descent. */
typedef bool NearFunction(void* search, int node, int first, unsigned near);

/* What a descent calls. All are constants in each use, so that the compiler makes a descent for each. */
typedef struct BoxVisitor {
  RowsFunction* rowsOf;
  ColumnsFunction* columnsOf;
  NearFunction* tell;
  bool isTwoWay; /* rows of the later of two nodes are compared, too, after those of the earlier */
} BoxVisitor;

/* Two nodes of a level, or one twice, and which of their members remain. */
typedef struct BoxVisit {
  int a;
  int b;
  unsigned rows;    /* of a, to be compared with members of b */
  int row;          /* of a, compared last */
  unsigned columns; /* of b, near that row, to be visited with it */
} BoxVisit;

static inline int memberOfNode(const Tree* layout, int level, int node, int k) {
  int count;
  return treeChildren(layout, level, node, &count) + k;
}

/* Members of node b that make a pair with member k of node a, if all members are rows. */
static inline unsigned notBefore(int a, int k, int b) {
  return a == b ? ~0u << k : ~0u;
}

/* Tells which members of node b are near rows of node a. False ends the descent. */
CT_INLINE bool tellRows(void* search, const Tree* layout, int level, int a, int b, unsigned rows, BoxVisitor visitor) {
  unsigned near[TREE_WIDTH]; /* of all rows, since a processor compares many at once if nothing is called in between */
  unsigned some = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    near[k] = visitor.columnsOf(search, level, a, k, b);
    some |= near[k] != 0 ? 1u << k : 0;
  }
  for (; some != 0; some &= some - 1) {
    const int k = __builtin_ctz(some);
    if (!visitor.tell(search, memberOfNode(layout, level, a, k), memberOfNode(layout, level, b, 0), near[k])) {
      return false;
    }
  }
  return true;
}

/* Tells which members of nodes of `lastLevel` are near each other; depth first, by rows, then columns. */
CT_INLINE void descendBoxes(void* search, const Tree* layout, int lastLevel, BoxVisitor visitor) {
  BoxVisit visits[TREE_MAX_LEVELS + 1]; /* per level */
  int level = layout->levelCount;
  if (level <= lastLevel) {
    visitor.tell(search, treeRoot(layout), treeRoot(layout), 1);
    return;
  }
  visits[level] = (BoxVisit){treeSuperRoot(layout), treeSuperRoot(layout), 0, 0, 1};
  while (level <= layout->levelCount) {
    BoxVisit* visit = &visits[level];
    int a = visit->a;
    int b = visit->b;
    if (visit->columns != 0) {
      const int row = memberOfNode(layout, level, a, visit->row);
      const int column = memberOfNode(layout, level, b, __builtin_ctz(visit->columns));
      visit->columns &= visit->columns - 1;
      a = row < column ? row : column;
      b = row < column ? column : row;
      level--;
    } else if (visit->rows != 0 && level == lastLevel) {
      if (!tellRows(search, layout, level, a, b, visit->rows, visitor)) {
        return;
      }
      visit->rows = 0;
      continue;
    } else if (visit->rows != 0) {
      visit->row = __builtin_ctz(visit->rows);
      visit->rows &= visit->rows - 1;
      visit->columns = visitor.columnsOf(search, level, a, visit->row, b);
      continue;
    } else if (visitor.isTwoWay && a < b) {
      a = visit->b;
      b = visit->a;
    } else {
      level++;
      continue;
    }
    visits[level] = (BoxVisit){a, b, visitor.rowsOf(search, level, a, b), 0, 0};
  }
}

#endif /* CT_BOX_DESCENT_H_ */
