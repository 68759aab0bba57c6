/* Which pairs of particles do not count, by pairs of leaves. */
#ifndef CT_PAIRMASK_H_
#define CT_PAIRMASK_H_

#include "ctenergy.h"

/* The partners of a leaf, ascending, are the leaves with which it has pairs that do not count. Each pair is kept in
 * both orders. A leaf is its own partner: of itself, only pairs of a slot with a higher one count. */
typedef struct PairMask {
  int* begin;                            /* per leaf, and one more: the first of its partners */
  int* partners;                         /* leaves */
  uint16_t (*bits)[CT_LEAF_WIDTH];       /* per partner and slot of the leaf: slots of the partner that do not count */
  uint16_t (*ofOwnImage)[CT_LEAF_WIDTH]; /* per leaf and slot: slots of its own image that do not count */
} PairMask;

/* False if there is no memory. */
bool ctPairMaskCreate(PairMask* mask, int leafCount, int pairCount, const int (*pairs)[2], const int* slotOf);
void ctPairMaskFree(PairMask* mask);

/* The slots of leaf b that do not count for each slot of leaf a; NULL: all count. O(log of the partners). */
static inline const uint16_t* pairMaskOf(const PairMask* mask, int a, int b) {
  int begin = mask->begin[a];
  int end = mask->begin[a + 1];
  if (b < mask->partners[begin] || b > mask->partners[end - 1]) {
    return NULL;
  }
  while (begin < end) {
    const int middle = begin + (end - begin) / 2;
    if (mask->partners[middle] < b) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return mask->partners[begin] == b ? mask->bits[begin] : NULL;
}

/* The same of an image of leaf a, in which all pairs of two slots count that are not excluded. */
static inline const uint16_t* pairMaskOfImage(const PairMask* mask, int a, int b) {
  return a == b ? mask->ofOwnImage[a] : pairMaskOf(mask, a, b);
}

#endif /* CT_PAIRMASK_H_ */
