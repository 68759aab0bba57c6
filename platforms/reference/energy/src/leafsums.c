#include "leafsums.h"

#include <stdlib.h>
#include <string.h>

/* The index of the first key that is not before this one. O(log count). */
static int placeOfKey(const LeafKey* keys, int count, LeafKey key) {
  /* Without a branch on the result, which processors would mispredict. */
  int begin = 0;
  for (int left = count; left > 0;) {
    const int half = (left + 1) / 2;
    begin += keys[begin + half - 1] < key ? half : 0;
    left -= half;
  }
  return begin;
}

bool ctLeafSumsCreate(LeafSums* sums, int leafCount) {
  sums->leafCount = leafCount;
  sums->rows = calloc((size_t)leafCount + 1, sizeof *sums->rows);
  return sums->rows != NULL;
}

void ctLeafSumsFree(LeafSums* sums) {
  for (int leaf = 0; sums->rows != NULL && leaf < sums->leafCount; leaf++) {
    free(sums->rows[leaf].keys);
    free(sums->rows[leaf].sums);
  }
  free(sums->rows);
  sums->rows = NULL;
}

void ctLeafSumsClear(LeafSums* sums) {
  for (int leaf = 0; leaf < sums->leafCount; leaf++) {
    sums->rows[leaf].count = 0;
  }
}

int ctLeafSumsFind(const LeafSums* sums, int a, int b, LeafKey key) {
  const LeafRow* row = &sums->rows[a];
  /* Without a cutoff, all leaves from a on are there. */
  if (row->count == sums->leafCount - a && row->keys[b - a] == key) {
    return b - a;
  }
  const int i = placeOfKey(row->keys, row->count, key);
  return i < row->count && row->keys[i] == key ? i : ABSENT;
}

/* Removes the pairs of a row whose sum is 0. */
static void removeZeros(LeafRow* row) {
  int kept = 0;
  for (int i = 0; i < row->count; i++) {
    if (row->sums[i] != 0) {
      row->keys[kept] = row->keys[i];
      row->sums[kept++] = row->sums[i];
    }
  }
  row->count = kept;
}

static bool setCapacity(LeafRow* row, int capacity) {
  LeafKey* keys = realloc(row->keys, (size_t)capacity * sizeof *keys);
  if (keys != NULL) {
    row->keys = keys;
  }
  double* values = keys != NULL ? realloc(row->sums, (size_t)capacity * sizeof *values) : NULL;
  if (values == NULL) {
    return false;
  }
  row->sums = values;
  row->capacity = capacity;
  return true;
}

/* Makes room for one more pair in a row that is full. */
static bool grow(LeafRow* row) {
  removeZeros(row);
  if (row->count <= row->capacity - row->capacity / 4 - 1) {
    return true;
  }
  return setCapacity(row, row->capacity + row->capacity / 2 + 8) || row->count < row->capacity;
}

bool ctLeafSumsAdd(LeafSums* sums, int a, LeafKey key, double sum) {
  LeafRow* row = &sums->rows[a];
  if (sum == 0) {
    return true;
  }
  if (row->count == row->capacity && !grow(row)) {
    return false;
  }
  const int i = placeOfKey(row->keys, row->count, key);
  memmove(row->keys + i + 1, row->keys + i, (size_t)(row->count - i) * sizeof *row->keys);
  memmove(row->sums + i + 1, row->sums + i, (size_t)(row->count - i) * sizeof *row->sums);
  row->keys[i] = key;
  row->sums[i] = sum;
  row->count++;
  return true;
}

bool ctLeafSumsCopy(const LeafSums* from, LeafSums* to) {
  for (int leaf = 0; leaf < from->leafCount; leaf++) {
    const LeafRow* source = &from->rows[leaf];
    LeafRow* row = &to->rows[leaf];
    row->count = 0;
    if (row->capacity < source->count && !setCapacity(row, source->capacity)) {
      return false;
    }
    row->count = source->count;
    if (row->count > 0) {
      memcpy(row->keys, source->keys, (size_t)row->count * sizeof *row->keys);
      memcpy(row->sums, source->sums, (size_t)row->count * sizeof *row->sums);
    }
  }
  return true;
}

double ctLeafSumsTotal(const LeafSums* sums) {
  double total = 0;
  for (int leaf = 0; leaf < sums->leafCount; leaf++) {
    const LeafRow* row = &sums->rows[leaf];
    double ofRow = 0;
    for (int i = 0; i < row->count; i++) {
      ofRow += row->sums[i];
    }
    total += ofRow;
  }
  return total;
}
