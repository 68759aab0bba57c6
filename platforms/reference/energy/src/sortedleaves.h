/* Leaves that are kept in ascending order. */
#ifndef CT_SORTEDLEAVES_H_
#define CT_SORTEDLEAVES_H_

/* The index of the first that is not before `leaf`. O(log count). */
static inline int placeOf(const int* leaves, int count, int leaf) {
  /* Without a branch on the result, which processors would mispredict. */
  int begin = 0;
  for (int left = count; left > 0;) {
    const int half = (left + 1) / 2;
    begin += leaves[begin + half - 1] < leaf ? half : 0;
    left -= half;
  }
  return begin;
}

#endif /* CT_SORTEDLEAVES_H_ */
