/* The descent over boxes along the world's axes: finds the near nodes of a level. */
#ifndef CT_BOX_DESCENT_H_
#define CT_BOX_DESCENT_H_

#include "set.h"

/* Returns the members (bits) of node a that may be near a member of node b. */
typedef unsigned RowsFunction(void* search, int level, int a, int b);

/* Returns the members (bits) of node b that are near member k of node a. */
typedef unsigned ColumnsFunction(void* search, int level, int a, int k, int b);

/* Receives a node and, as bits, members of another that are near it; `first` is member 0. False ends the descent. */
typedef bool NearFunction(void* search, int node, int first, unsigned near);

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

/* The columns of a row: pairs of members of one node belong to the first of them. */
CT_INLINE unsigned columnsFrom(void* search, int level, int a, int k, int b, ColumnsFunction* columnsOf) {
  return columnsOf(search, level, a, k, b) & (a == b ? ~0u << k : ~0u);
}

/* Tells which members of node b are near rows of node a. False ends the descent. */
CT_INLINE bool tellRows(void* search, const Tree* layout, int level, int a, int b, unsigned rows,
                        ColumnsFunction* columnsOf, NearFunction* tell) {
  unsigned near[TREE_WIDTH]; /* of all rows, since a processor compares many at once if nothing is called in between */
  unsigned some = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    near[k] = columnsFrom(search, level, a, k, b, columnsOf);
    some |= near[k] != 0 ? 1u << k : 0;
  }
  for (; some != 0; some &= some - 1) {
    const int k = __builtin_ctz(some);
    if (!tell(search, memberOfNode(layout, level, a, k), memberOfNode(layout, level, b, 0), near[k])) {
      return false;
    }
  }
  return true;
}

/* Tells which members of nodes of `lastLevel` are near each other, each pair once, the lower first; depth first, by
 * rows, then columns. The functions are constants in each use, so that the compiler makes a descent for each. */
CT_INLINE void descendBoxes(void* search, const Tree* layout, int lastLevel, RowsFunction* rowsOf,
                            ColumnsFunction* columnsOf, NearFunction* tell) {
  BoxVisit visits[TREE_MAX_LEVELS + 1]; /* per level */
  int level = layout->levelCount;
  if (level <= lastLevel) {
    tell(search, treeRoot(layout), treeRoot(layout), 1);
    return;
  }
  visits[level] = (BoxVisit){treeSuperRoot(layout), treeSuperRoot(layout), 0, 0, 1};
  while (level <= layout->levelCount) {
    BoxVisit* visit = &visits[level];
    if (visit->columns == 0) {
      if (visit->rows == 0) {
        level++;
        continue;
      }
      visit->row = __builtin_ctz(visit->rows);
      visit->rows &= visit->rows - 1;
      visit->columns = columnsFrom(search, level, visit->a, visit->row, visit->b, columnsOf);
      continue;
    }
    const int a = memberOfNode(layout, level, visit->a, visit->row);
    const int b = memberOfNode(layout, level, visit->b, __builtin_ctz(visit->columns));
    visit->columns &= visit->columns - 1;
    const unsigned rows = rowsOf(search, level - 1, a, b);
    if (level - 1 > lastLevel) {
      visits[--level] = (BoxVisit){a, b, rows, 0, 0};
    } else if (!tellRows(search, layout, lastLevel, a, b, rows, columnsOf, tell)) {
      return;
    }
  }
}

#endif /* CT_BOX_DESCENT_H_ */
