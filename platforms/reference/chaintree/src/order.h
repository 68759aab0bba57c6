/* Sorting: in space, of numbers, of pairs. */
#ifndef CT_ORDER_H_
#define CT_ORDER_H_

#include <stdbool.h>
#include <stddef.h>

/* The number of members of a node of the tree. */
enum { TREE_WIDTH_BITS = 4, TREE_WIDTH = 1 << TREE_WIDTH_BITS };

/* The index in its level of the node that covers a slot, or a node of the level below, of this index. One instruction;
 * a division by TREE_WIDTH of what might be negative takes four. */
static inline int coveringNode(int index) {
  return index >> TREE_WIDTH_BITS;
}

/* Which of that node's members it is. */
static inline int memberIndex(int index) {
  return index & (TREE_WIDTH - 1);
}

/* Permutes ids so that consecutive runs of TREE_WIDTH, and of its powers, are compact in space: this makes the volumes
 * of obstacles and of large links tight. Point id is points[3 * id .. 3 * id + 2]. O(n log n) expected. The result
 * depends on nothing else. */
void ctSpatialOrder(int* ids, int count, const double* points);

/* Sorts values, ascending. */
void ctSortInts(int* values, int count);

/* The index of the first of ascending values [begin, end) that is not below `value`. O(log of their number). */
static inline int ascendingFrom(const int* values, int begin, int end, int value) {
  while (begin < end) {
    const int middle = begin + (end - begin) / 2;
    if (values[middle] < value) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

/* Sorts pairs of ids below idCount by the first, then the second. O(count + idCount). False, and nothing changed, if
 * there is no memory. */
bool ctSortPairs(size_t count, int* firsts, int* seconds, int idCount);

/* Turns counts of `count` groups, in begin[group + 1], into the first index of each group. */
void ctAccumulate(int* begin, int count);

#endif /* CT_ORDER_H_ */
