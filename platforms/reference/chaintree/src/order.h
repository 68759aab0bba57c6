/* The orders that layouts need. */
#ifndef CT_ORDER_H_
#define CT_ORDER_H_

/* Permutes ids so that consecutive runs of TREE_WIDTH, and of its powers, are compact in space: what makes the static
 * hierarchy of obstacles and of large links tight. Point id is points[3 * id .. 3 * id + 2]. O(n log n) expected; the
 * result depends on nothing else. */
void ctSpatialOrder(int* ids, int count, const double* points);

/* Ascending. */
void ctSortInts(int* values, int count);

#endif /* CT_ORDER_H_ */
