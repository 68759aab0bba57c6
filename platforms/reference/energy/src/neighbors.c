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

void ctNeighborsClear(Neighbors* neighbors) {
  for (int leaf = 0; leaf < neighbors->leafCount; leaf++) {
    neighbors->rows[leaf].count = 0;
  }
  neighbors->pairCount = 0;
  neighbors->freeCount = 0;
}

int ctNeighborsFind(const Neighbors* neighbors, int a, int b) {
  const NeighborRow* row = &neighbors->rows[a];
  const int i = placeOf(row->leaves, row->count, b);
  return i < row->count && row->leaves[i] == b ? row->pairs[i] : CT_NULL;
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

int ctNeighborsReserve(Neighbors* neighbors) {
  if (neighbors->freeCount == 0 && neighbors->pairCount == neighbors->pairCapacity &&
      !setCapacity(neighbors, neighbors->pairCapacity + neighbors->pairCapacity / 2 + 64)) {
    return CT_NULL;
  }
  const int pair = neighbors->freeCount > 0 ? neighbors->free[--neighbors->freeCount] : neighbors->pairCount++;
  PairRecord* record = &neighbors->records[pair];
  record->energy = 0;
  record->trial = 0;
  record->hasPairs = record->hasBorn = false;
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

static void insert(NeighborRow* row, int leaf, int pair) {
  const int i = placeOf(row->leaves, row->count, leaf);
  memmove(row->leaves + i + 1, row->leaves + i, (size_t)(row->count - i) * sizeof *row->leaves);
  memmove(row->pairs + i + 1, row->pairs + i, (size_t)(row->count - i) * sizeof *row->pairs);
  row->leaves[i] = leaf;
  row->pairs[i] = pair;
  row->count++;
}

static void drop(NeighborRow* row, int leaf) {
  const int i = placeOf(row->leaves, row->count, leaf);
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
  insert(rowA, b, pair);
  if (a != b) {
    insert(rowB, a, pair);
  }
  return true;
}

void ctNeighborsRemove(Neighbors* neighbors, int a, int b) {
  drop(&neighbors->rows[a], b);
  if (a != b) {
    drop(&neighbors->rows[b], a);
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
  if (pairs > 0) {
    memcpy(copy->records, original->records, pairs * sizeof *copy->records);
    memcpy(copy->free, original->free, (size_t)original->freeCount * sizeof *copy->free);
  }
  return true;
}
