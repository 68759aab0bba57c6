#include "pairmask.h"

#include <stdlib.h>

typedef struct LeafLink {
  int leaf;
  int partner;
} LeafLink;

static int compare(const void* a, const void* b) {
  const LeafLink* p = a;
  const LeafLink* q = b;
  if (p->leaf != q->leaf) {
    return p->leaf < q->leaf ? -1 : 1;
  }
  return (p->partner > q->partner) - (p->partner < q->partner);
}

/* Lists each leaf with its partners, sorted, each once; returns how many there are. */
static int listPartners(LeafLink* links, int leafCount, int pairCount, const int (*pairs)[2], const int* slotOf) {
  int count = 0;
  for (int leaf = 0; leaf < leafCount; leaf++) {
    links[count++] = (LeafLink){leaf, leaf};
  }
  for (int i = 0; i < pairCount; i++) {
    const int a = slotOf[pairs[i][0]] / CT_LEAF_WIDTH;
    const int b = slotOf[pairs[i][1]] / CT_LEAF_WIDTH;
    if (a != b) {
      links[count++] = (LeafLink){a, b};
      links[count++] = (LeafLink){b, a};
    }
  }
  qsort(links, (size_t)count, sizeof *links, compare);
  int kept = 0;
  for (int i = 0; i < count; i++) {
    if (kept == 0 || compare(&links[kept - 1], &links[i]) != 0) {
      links[kept++] = links[i];
    }
  }
  return kept;
}

static void exclude(PairMask* mask, int slotA, int slotB) {
  const int a = slotA / CT_LEAF_WIDTH;
  const int b = slotB / CT_LEAF_WIDTH;
  uint16_t* bits = (uint16_t*)(uintptr_t)pairMaskOf(mask, a, b);
  bits[slotA % CT_LEAF_WIDTH] = (uint16_t)(bits[slotA % CT_LEAF_WIDTH] | 1u << slotB % CT_LEAF_WIDTH);
}

static void excludePair(PairMask* mask, int slotA, int slotB) {
  exclude(mask, slotA, slotB);
  if (slotA / CT_LEAF_WIDTH == slotB / CT_LEAF_WIDTH) {
    uint16_t* bits = &mask->ofOwnImage[slotA / CT_LEAF_WIDTH][slotA % CT_LEAF_WIDTH];
    *bits = (uint16_t)(*bits | 1u << slotB % CT_LEAF_WIDTH);
  }
}

bool ctPairMaskCreate(PairMask* mask, int leafCount, int pairCount, const int (*pairs)[2], const int* slotOf) {
  LeafLink* links = malloc(((size_t)leafCount + 2 * (size_t)pairCount + 1) * sizeof *links);
  const int count = links != NULL ? listPartners(links, leafCount, pairCount, pairs, slotOf) : 0;
  mask->begin = calloc((size_t)leafCount + 1, sizeof *mask->begin);
  mask->partners = malloc(((size_t)count + 1) * sizeof *mask->partners);
  mask->bits = calloc((size_t)count + 1, sizeof *mask->bits);
  mask->ofOwnImage = calloc((size_t)leafCount + 1, sizeof *mask->ofOwnImage);
  if (links == NULL || mask->begin == NULL || mask->partners == NULL || mask->bits == NULL ||
      mask->ofOwnImage == NULL) {
    free(links);
    ctPairMaskFree(mask);
    return false;
  }
  for (int i = 0; i < count; i++) {
    mask->partners[i] = links[i].partner;
    mask->begin[links[i].leaf + 1] = i + 1;
  }
  free(links);
  for (int leaf = 0; leaf < leafCount; leaf++) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      for (int lower = 0; lower <= k; lower++) {
        exclude(mask, leaf * CT_LEAF_WIDTH + k, leaf * CT_LEAF_WIDTH + lower);
      }
    }
  }
  for (int i = 0; i < pairCount; i++) {
    excludePair(mask, slotOf[pairs[i][0]], slotOf[pairs[i][1]]);
    excludePair(mask, slotOf[pairs[i][1]], slotOf[pairs[i][0]]);
  }
  return true;
}

void ctPairMaskFree(PairMask* mask) {
  free(mask->begin);
  free(mask->partners);
  free(mask->bits);
  free(mask->ofOwnImage);
  *mask = (PairMask){0};
}
