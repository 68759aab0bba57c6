#include "sectionsums.h"

#include <stdlib.h>
#include <string.h>

#include "sortedleaves.h"

/* ---- Life ---- */

bool ctSectionSumsCreate(SectionSums* sums, int leafCount) {
  *sums = (SectionSums){.leafCount = leafCount, .freePair = NOT_KEPT, .freeTable = NOT_KEPT};
  sums->rows = calloc((size_t)leafCount + 1, sizeof *sums->rows);
  return sums->rows != NULL;
}

void ctSectionSumsFree(SectionSums* sums) {
  for (int leaf = 0; sums->rows != NULL && leaf < sums->leafCount; leaf++) {
    free(sums->rows[leaf].leaves);
    free(sums->rows[leaf].kept);
  }
  free(sums->rows);
  free(sums->pairs);
  free(sums->tables);
  *sums = (SectionSums){0};
}

void ctSectionSumsClear(SectionSums* sums) {
  for (int leaf = 0; leaf < sums->leafCount; leaf++) {
    sums->rows[leaf].count = 0;
  }
  sums->pairCount = 0;
  sums->tableCount = 0;
  sums->freePair = NOT_KEPT;
  sums->freeTable = NOT_KEPT;
}

/* ---- Memory ---- */

static bool setRowCapacity(SectionRow* row, int capacity) {
  int* leaves = realloc(row->leaves, (size_t)capacity * sizeof *leaves);
  if (leaves != NULL) {
    row->leaves = leaves;
  }
  int* kept = leaves != NULL ? realloc(row->kept, (size_t)capacity * sizeof *kept) : NULL;
  if (kept == NULL) {
    return false;
  }
  row->kept = kept;
  row->capacity = capacity;
  return true;
}

/* Makes room for so many entries of this size. */
static bool reserve(void** array, int* capacity, int count, size_t size) {
  if (count <= *capacity) {
    return true;
  }
  const size_t wanted = (size_t)count + (size_t)count / 2 + 8;
  void* grown = wanted < INT32_MAX ? realloc(*array, wanted * size) : NULL;
  if (grown == NULL) {
    return false;
  }
  *array = grown;
  *capacity = (int)wanted;
  return true;
}

static int takeTable(SectionSums* sums) {
  const int free = sums->freeTable;
  if (free != NOT_KEPT) {
    memcpy(&sums->freeTable, &sums->tables[free], sizeof sums->freeTable);
    return free;
  }
  return reserve((void**)&sums->tables, &sums->tableCapacity, sums->tableCount + 1, sizeof *sums->tables)
             ? sums->tableCount++
             : NOT_KEPT;
}

/* A free table holds the index of the next. */
static void giveTableBack(SectionSums* sums, KeptPair* pair) {
  if (pair->table != NOT_KEPT) {
    memcpy(&sums->tables[pair->table], &sums->freeTable, sizeof sums->freeTable);
    sums->freeTable = pair->table;
    pair->table = NOT_KEPT;
  }
}

static int takePair(SectionSums* sums) {
  const int free = sums->freePair;
  if (free != NOT_KEPT) {
    sums->freePair = sums->pairs[free].table;
    return free;
  }
  return reserve((void**)&sums->pairs, &sums->pairCapacity, sums->pairCount + 1, sizeof *sums->pairs)
             ? sums->pairCount++
             : NOT_KEPT;
}

/* ---- Pairs ---- */

int ctSectionSumsSearch(SectionSums* sums, int leaf, int other) {
  SectionRow* row = &sums->rows[leaf];
  const int i = placeOf(row->leaves, row->count, other);
  const bool isThere = i < row->count && row->leaves[i] == other;
  row->cursor = isThere ? i + 1 : i;
  return isThere ? row->kept[i] : NOT_KEPT;
}

static void removeFromRow(SectionRow* row, int other) {
  const int i = placeOf(row->leaves, row->count, other);
  const size_t behind = (size_t)(row->count - i - 1);
  memmove(row->leaves + i, row->leaves + i + 1, behind * sizeof *row->leaves);
  memmove(row->kept + i, row->kept + i + 1, behind * sizeof *row->kept);
  row->count--;
}

/* Removes the pairs of a row that have nothing but zeros. */
static void removeZeros(SectionSums* sums, int leaf) {
  SectionRow* row = &sums->rows[leaf];
  for (int i = row->count - 1; i >= 0; i--) {
    const int kept = row->kept[i];
    const int other = row->leaves[i];
    KeptPair* pair = &sums->pairs[kept];
    if (pair->sum.knowledge == NOTHING_THERE) {
      removeFromRow(row, other);
      if (other != leaf) {
        removeFromRow(&sums->rows[other], leaf);
      }
      pair->table = sums->freePair;
      sums->freePair = kept;
    }
  }
}

/* Makes room for one more pair in a row. */
static bool growRow(SectionSums* sums, int leaf) {
  SectionRow* row = &sums->rows[leaf];
  if (row->count < row->capacity) {
    return true;
  }
  removeZeros(sums, leaf);
  if (row->count <= row->capacity - row->capacity / 4 - 1) {
    return true;
  }
  return setRowCapacity(row, row->capacity + row->capacity / 2 + 8) || row->count < row->capacity;
}

static void insert(SectionRow* row, int other, int kept) {
  const int i = placeOf(row->leaves, row->count, other);
  memmove(row->leaves + i + 1, row->leaves + i, (size_t)(row->count - i) * sizeof *row->leaves);
  memmove(row->kept + i + 1, row->kept + i, (size_t)(row->count - i) * sizeof *row->kept);
  row->leaves[i] = other;
  row->kept[i] = kept;
  row->count++;
}

static int add(SectionSums* sums, int a, int b) {
  if (!growRow(sums, a) || !growRow(sums, b)) {
    return NOT_KEPT;
  }
  const int kept = takePair(sums);
  if (kept != NOT_KEPT) {
    sums->pairs[kept] = (KeptPair){.table = NOT_KEPT};
    insert(&sums->rows[a], b, kept);
    if (a != b) {
      insert(&sums->rows[b], a, kept);
    }
  }
  return kept;
}

static bool isZero(const SectionTable* table) {
  uint64_t some = 0;
  for (int i = 0; i < MOST_SECTIONS * MOST_SECTIONS; i++) {
    some |= (uint64_t)table->sums[i / MOST_SECTIONS][i % MOST_SECTIONS];
  }
  return some == 0;
}

static void takeOver(SectionTable* table, const SectionTable* from, unsigned changed, bool isTransposed) {
  for (; changed != 0; changed &= changed - 1) {
    const int s = __builtin_ctz(changed);
    for (int t = 0; t < MOST_SECTIONS; t++) {
      *(isTransposed ? &table->sums[t][s] : &table->sums[s][t]) = from->sums[s][t];
    }
  }
}

bool ctSectionSumsSet(SectionSums* sums, int a, int b, int kept, const PairSum* sum, const SectionTable* table,
                      unsigned changed, bool isTransposed) {
  if (kept == NOT_KEPT) {
    if (sum->knowledge == NOTHING_THERE || (sum->knowledge == SECTIONS_KNOWN && isZero(table))) {
      return true;
    }
    kept = add(sums, a, b);
    if (kept == NOT_KEPT) {
      return false;
    }
  }
  KeptPair* pair = &sums->pairs[kept];
  pair->sum = *sum;
  if (sum->knowledge != SECTIONS_KNOWN) {
    giveTableBack(sums, pair);
    return true;
  }
  if (pair->table == NOT_KEPT) {
    pair->table = takeTable(sums);
    if (pair->table == NOT_KEPT) {
      return false;
    }
    sums->tables[pair->table] = (SectionTable){{{0}}};
  }
  SectionTable* own = &sums->tables[pair->table];
  takeOver(own, table, changed, isTransposed);
  if (sum->sum.exact == 0 && isZero(own)) {
    pair->sum.knowledge = NOTHING_THERE;
    giveTableBack(sums, pair);
  }
  return true;
}

/* ---- All ---- */

bool ctSectionSumsCopy(const SectionSums* from, SectionSums* to) {
  ctSectionSumsClear(to);
  for (int leaf = 0; leaf < from->leafCount; leaf++) {
    const SectionRow* source = &from->rows[leaf];
    SectionRow* row = &to->rows[leaf];
    if (row->capacity < source->count && !setRowCapacity(row, source->capacity)) {
      return false;
    }
    row->count = source->count;
    row->cursor = 0;
    if (row->count > 0) {
      memcpy(row->leaves, source->leaves, (size_t)row->count * sizeof *row->leaves);
      memcpy(row->kept, source->kept, (size_t)row->count * sizeof *row->kept);
    }
  }
  if (!reserve((void**)&to->pairs, &to->pairCapacity, from->pairCount, sizeof *to->pairs) ||
      !reserve((void**)&to->tables, &to->tableCapacity, from->tableCount, sizeof *to->tables)) {
    return false;
  }
  to->pairCount = from->pairCount;
  to->freePair = from->freePair;
  to->tableCount = from->tableCount;
  to->freeTable = from->freeTable;
  if (from->pairCount > 0) {
    memcpy(to->pairs, from->pairs, (size_t)from->pairCount * sizeof *to->pairs);
  }
  if (from->tableCount > 0) {
    memcpy(to->tables, from->tables, (size_t)from->tableCount * sizeof *to->tables);
  }
  return true;
}

double ctSectionSumsTotal(const SectionSums* sums) {
  double total = 0;
  for (int leaf = 0; leaf < sums->leafCount; leaf++) {
    const SectionRow* row = &sums->rows[leaf];
    double ofRow = 0;
    for (int i = 0; i < row->count; i++) {
      if (row->leaves[i] >= leaf) {
        ofRow += sumOfPair(&sums->pairs[row->kept[i]].sum);
      }
    }
    total += ofRow;
  }
  return total;
}
