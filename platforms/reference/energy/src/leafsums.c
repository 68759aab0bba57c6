#include "leafsums.h"

#include <stdlib.h>
#include <string.h>

#include "sortedleaves.h"

bool ctLeafSumsCreate(LeafSums* sums, int leafCount) {
  sums->leafCount = leafCount;
  sums->rows = calloc((size_t)leafCount + 1, sizeof *sums->rows);
  return sums->rows != NULL;
}

void ctLeafSumsFree(LeafSums* sums) {
  for (int leaf = 0; sums->rows != NULL && leaf < sums->leafCount; leaf++) {
    free(sums->rows[leaf].leaves);
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

int ctLeafSumsFind(const LeafSums* sums, int a, int b) {
  const LeafRow* row = &sums->rows[a];
  /* Without a cutoff, all leaves from a on are there. */
  const int i = row->count == sums->leafCount - a ? b - a : placeOf(row->leaves, row->count, b);
  return i < row->count && row->leaves[i] == b ? i : ABSENT;
}

/* Removes the pairs of a row whose sum is 0. */
static void removeZeros(LeafRow* row) {
  int kept = 0;
  for (int i = 0; i < row->count; i++) {
    if (row->sums[i] != 0) {
      row->leaves[kept] = row->leaves[i];
      row->sums[kept++] = row->sums[i];
    }
  }
  row->count = kept;
}

static bool setCapacity(LeafRow* row, int capacity) {
  int* leaves = realloc(row->leaves, (size_t)capacity * sizeof *leaves);
  if (leaves != NULL) {
    row->leaves = leaves;
  }
  double* values = leaves != NULL ? realloc(row->sums, (size_t)capacity * sizeof *values) : NULL;
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

bool ctLeafSumsAdd(LeafSums* sums, int a, int b, double sum) {
  LeafRow* row = &sums->rows[a];
  if (sum == 0) {
    return true;
  }
  if (row->count == row->capacity && !grow(row)) {
    return false;
  }
  const int i = placeOf(row->leaves, row->count, b);
  memmove(row->leaves + i + 1, row->leaves + i, (size_t)(row->count - i) * sizeof *row->leaves);
  memmove(row->sums + i + 1, row->sums + i, (size_t)(row->count - i) * sizeof *row->sums);
  row->leaves[i] = b;
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
      memcpy(row->leaves, source->leaves, (size_t)row->count * sizeof *row->leaves);
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
