#include "neighbors.h"

#include <stdlib.h>
#include <string.h>

#include "sortedleaves.h"

bool ctNeighborsCreate(Neighbors* neighbors, int leafCount) {
  *neighbors = (Neighbors){.leafCount = leafCount};
  neighbors->rows = calloc((size_t)leafCount + 1, sizeof *neighbors->rows);
  return neighbors->rows != NULL;
}

void ctNeighborsFree(Neighbors* neighbors) {
  for (int leaf = 0; neighbors->rows != NULL && leaf < neighbors->leafCount; leaf++) {
    free(neighbors->rows[leaf].leaves);
    free(neighbors->rows[leaf].pairs);
  }
  free(neighbors->rows);
  freeLines(neighbors->records);
  free(neighbors->free);
  *neighbors = (Neighbors){0};
}

void ctNeighborsClear(Neighbors* neighbors, bool hasImages) {
  neighbors->hasImages = hasImages;
  for (int leaf = 0; leaf < neighbors->leafCount; leaf++) {
    neighbors->rows[leaf].count = 0;
  }
  neighbors->pairCount = 0;
  neighbors->freeCount = 0;
}

/* Below 0, 0 or above 0 as an image is before another, the same, or behind it. */
static int compareImages(const int a[3], const int b[3]) {
  for (int k = 0; k < 2; k++) {
    if (a[k] != b[k]) {
      return a[k] < b[k] ? -1 : 1;
    }
  }
  return (a[2] > b[2]) - (a[2] < b[2]);
}

/* The index in a row of the first pair that is not before the pair with this leaf in this image. */
static int placeOfPair(const Neighbors* neighbors, const NeighborRow* row, int leaf, const int image[3]) {
  int i = placeOf(row->leaves, row->count, leaf);
  while (neighbors->hasImages && i < row->count && row->leaves[i] == leaf &&
         compareImages(neighbors->records[row->pairs[i]].image, image) < 0) {
    i++;
  }
  return i;
}

int ctNeighborsFind(const Neighbors* neighbors, int a, int b, const int image[3]) {
  const NeighborRow* row = &neighbors->rows[a];
  const int i = placeOfPair(neighbors, row, b, image);
  if (i >= row->count || row->leaves[i] != b) {
    return CT_NULL;
  }
  const int pair = row->pairs[i];
  return neighbors->hasImages && compareImages(neighbors->records[pair].image, image) != 0 ? CT_NULL : pair;
}

/* ---- Numbers ---- */

static bool setCapacity(Neighbors* neighbors, int capacity) {
  int* numbers = realloc(neighbors->free, (size_t)capacity * sizeof *numbers);
  neighbors->free = numbers != NULL ? numbers : neighbors->free;
  if (numbers == NULL || !growLines((void**)&neighbors->records, (size_t)neighbors->pairCount, (size_t)capacity,
                                    sizeof *neighbors->records)) {
    return false;
  }
  neighbors->pairCapacity = capacity;
  return true;
}

int ctNeighborsReserve(Neighbors* neighbors, const int image[3]) {
  if (neighbors->freeCount == 0 && neighbors->pairCount == neighbors->pairCapacity &&
      !setCapacity(neighbors, neighbors->pairCapacity + neighbors->pairCapacity / 2 + 64)) {
    return CT_NULL;
  }
  const int pair = neighbors->freeCount > 0 ? neighbors->free[--neighbors->freeCount] : neighbors->pairCount++;
  PairRecord* record = &neighbors->records[pair];
  record->energy = 0;
  record->trial = 0;
  record->hasPairs = record->hasBorn = false;
  record->moves = 0;
  memcpy(record->image, image, sizeof record->image);
  return pair;
}

void ctNeighborsRelease(Neighbors* neighbors, int pair) {
  neighbors->free[neighbors->freeCount++] = pair;
}

/* ---- Rows ---- */

static bool growRow(NeighborRow* row) {
  const size_t capacity = (size_t)(row->capacity + row->capacity / 2 + 8);
  int* leaves = realloc(row->leaves, capacity * sizeof *leaves);
  row->leaves = leaves != NULL ? leaves : row->leaves;
  int* pairs = leaves != NULL ? realloc(row->pairs, capacity * sizeof *pairs) : NULL;
  if (pairs == NULL) {
    return false;
  }
  row->pairs = pairs;
  row->capacity = (int)capacity;
  return true;
}

static void insert(const Neighbors* neighbors, NeighborRow* row, int leaf, int pair) {
  const int i = placeOfPair(neighbors, row, leaf, neighbors->records[pair].image);
  memmove(row->leaves + i + 1, row->leaves + i, (size_t)(row->count - i) * sizeof *row->leaves);
  memmove(row->pairs + i + 1, row->pairs + i, (size_t)(row->count - i) * sizeof *row->pairs);
  row->leaves[i] = leaf;
  row->pairs[i] = pair;
  row->count++;
}

static void drop(const Neighbors* neighbors, NeighborRow* row, int leaf, int pair) {
  const int i = placeOfPair(neighbors, row, leaf, neighbors->records[pair].image);
  row->count--;
  memmove(row->leaves + i, row->leaves + i + 1, (size_t)(row->count - i) * sizeof *row->leaves);
  memmove(row->pairs + i, row->pairs + i + 1, (size_t)(row->count - i) * sizeof *row->pairs);
}

bool ctNeighborsAdd(Neighbors* neighbors, int a, int b, int pair) {
  NeighborRow* rowA = &neighbors->rows[a];
  NeighborRow* rowB = &neighbors->rows[b];
  if ((rowA->count == rowA->capacity && !growRow(rowA)) || (rowB->count == rowB->capacity && !growRow(rowB))) {
    return false;
  }
  insert(neighbors, rowA, b, pair);
  if (a != b) {
    insert(neighbors, rowB, a, pair);
  }
  return true;
}

void ctNeighborsRemove(Neighbors* neighbors, int a, int b, int pair) {
  drop(neighbors, &neighbors->rows[a], b, pair);
  if (a != b) {
    drop(neighbors, &neighbors->rows[b], a, pair);
  }
}

/* ---- Copies ---- */

bool ctNeighborsCopy(Neighbors* copy, const Neighbors* original) {
  if (copy->pairCapacity < original->pairCapacity && !setCapacity(copy, original->pairCapacity)) {
    return false;
  }
  for (int leaf = 0; leaf < original->leafCount; leaf++) {
    const NeighborRow* from = &original->rows[leaf];
    NeighborRow* to = &copy->rows[leaf];
    while (to->capacity < from->count) {
      if (!growRow(to)) {
        return false;
      }
    }
    to->count = from->count;
    if (from->count > 0) {
      memcpy(to->leaves, from->leaves, (size_t)from->count * sizeof *to->leaves);
      memcpy(to->pairs, from->pairs, (size_t)from->count * sizeof *to->pairs);
    }
  }
  const size_t pairs = (size_t)original->pairCount;
  copy->pairCount = original->pairCount;
  copy->freeCount = original->freeCount;
  copy->hasImages = original->hasImages;
  if (pairs > 0) {
    memcpy(copy->records, original->records, pairs * sizeof *copy->records);
    memcpy(copy->free, original->free, (size_t)original->freeCount * sizeof *copy->free);
  }
  return true;
}
