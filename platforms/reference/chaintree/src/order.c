#include "order.h"

#include <float.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct Key {
  const double* points;
  int axis;
} Key;

/* Ties are decided by index, so that the order is total. */
static bool before(const Key* key, int a, int b) {
  const double x = key->points[3 * (size_t)a + (size_t)key->axis];
  const double y = key->points[3 * (size_t)b + (size_t)key->axis];
  return x < y || (x == y && a < b);
}

static void swap(int* ids, int a, int b) {
  const int id = ids[a];
  ids[a] = ids[b];
  ids[b] = id;
}

/* Quickselect: moves the `middle` lowest ids to the front. */
static void selectFirst(const Key* key, int* ids, int count, int middle) {
  int low = 0;
  int high = count - 1;
  while (low < high) {
    /* The median of three is the pivot. */
    const int centre = low + (high - low) / 2;
    if (before(key, ids[centre], ids[low])) {
      swap(ids, centre, low);
    }
    if (before(key, ids[high], ids[low])) {
      swap(ids, high, low);
    }
    if (before(key, ids[high], ids[centre])) {
      swap(ids, high, centre);
    }
    const int pivot = ids[centre];
    int i = low;
    int j = high;
    while (i <= j) {
      while (before(key, ids[i], pivot)) {
        i++;
      }
      while (before(key, pivot, ids[j])) {
        j--;
      }
      if (i <= j) {
        swap(ids, i++, j--);
      }
    }
    if (middle <= j) {
      high = j;
    } else if (middle >= i) {
      low = i;
    } else {
      return;
    }
  }
}

static int longestAxis(const int* ids, int count, const double* points) {
  int longest = 0;
  double coordinateBound = -1;
  for (int axis = 0; axis < 3; axis++) {
    double low = DBL_MAX;
    double high = -DBL_MAX;
    for (int i = 0; i < count; i++) {
      const double x = points[3 * (size_t)ids[i] + (size_t)axis];
      low = x < low ? x : low;
      high = x > high ? x : high;
    }
    if (high - low > coordinateBound) {
      coordinateBound = high - low;
      longest = axis;
    }
  }
  return longest;
}

void ctSpatialOrder(int* ids, int count, const double* points) {
  while (count > TREE_WIDTH) {
    /* Split at whole nodes, so that no node spans both halves. */
    int run = TREE_WIDTH;
    while (run <= (count - 1) / TREE_WIDTH) {
      run *= TREE_WIDTH;
    }
    const int middle = (count / 2 + run - 1) / run * run;
    const Key key = {points, longestAxis(ids, count, points)};
    selectFirst(&key, ids, count, middle);
    ctSpatialOrder(ids, middle, points);
    ids += middle;
    count -= middle;
  }
  for (int i = 1; i < count; i++) {
    for (int j = i; j > 0 && ids[j] < ids[j - 1]; j--) {
      swap(ids, j, j - 1);
    }
  }
}

static int compareInts(const void* a, const void* b) {
  const int x = *(const int*)a;
  const int y = *(const int*)b;
  return (x > y) - (x < y);
}

void ctSortInts(int* values, int count) {
  if (count > 1) {
    qsort(values, (size_t)count, sizeof(int), compareInts);
  }
}

void ctAccumulate(int* begin, int count) {
  for (int i = 0; i < count; i++) {
    begin[i + 1] += begin[i];
  }
}

/* Insertion sort: quick if values almost ascend, as they do where links and particles are numbered alike. */
static void sortFew(int* values, size_t count) {
  for (size_t i = 1; i < count; i++) {
    const int value = values[i];
    size_t j = i;
    for (; j > 0 && values[j - 1] > value; j--) {
      values[j] = values[j - 1];
    }
    values[j] = value;
  }
}

/* Pairs come in runs of one id. Counting them one by one would wait for each sum, so the list is read as several
 * streams at once, each with a count of its own for each id. */
enum { STREAMS = 4 };

/* Gathers the second ids of pairs in rows, one for each first id. Row id begins at begins[STREAMS * id]. */
static void gatherRows(size_t count, const int* firsts, const int* seconds, int idCount, uint32_t* begins, int* rows) {
  /* Counts are kept two entries on, so that filling the list turns them into its begins. */
  uint32_t* next = begins + 1;
  const size_t length = count / STREAMS;
  for (size_t i = 0; i < length; i++) {
    for (size_t s = 0; s < STREAMS; s++) {
      next[STREAMS * (size_t)firsts[s * length + i] + s + 1]++;
    }
  }
  for (size_t i = STREAMS * length; i < count; i++) {
    next[STREAMS * (size_t)firsts[i] + STREAMS]++;
  }
  for (size_t i = 0; i < STREAMS * (size_t)idCount; i++) {
    next[i + 1] += next[i];
  }
  for (size_t i = 0; i < length; i++) {
    for (size_t s = 0; s < STREAMS; s++) {
      rows[next[STREAMS * (size_t)firsts[s * length + i] + s]++] = seconds[s * length + i];
    }
  }
  for (size_t i = STREAMS * length; i < count; i++) {
    rows[next[STREAMS * (size_t)firsts[i] + STREAMS - 1]++] = seconds[i];
  }
}

/* True if pairs ascend. Without a branch for each: mostly all do, or early ones do not. */
static bool pairsAscend(size_t count, const int* firsts, const int* seconds) {
  enum { AT_ONCE = 256 };
  for (size_t begin = 0; begin + 1 < count; begin += AT_ONCE) {
    const size_t end = begin + AT_ONCE < count - 1 ? begin + AT_ONCE : count - 1;
    int falls = 0;
    for (size_t i = begin; i < end; i++) {
      falls |= (firsts[i] > firsts[i + 1]) | ((firsts[i] == firsts[i + 1]) & (seconds[i] >= seconds[i + 1]));
    }
    if (falls != 0) {
      return false;
    }
  }
  return true;
}

bool ctSortPairs(size_t count, int* firsts, int* seconds, int idCount) {
  enum { FEW = 256 };
  if (pairsAscend(count, firsts, seconds)) {
    return true;
  }
  uint32_t* begins = calloc(STREAMS * (size_t)idCount + 2, sizeof *begins);
  int* rows = malloc((count + 1) * sizeof *rows);
  const bool hasMemory = begins != NULL && rows != NULL;
  if (hasMemory) {
    gatherRows(count, firsts, seconds, idCount, begins, rows);
    for (int id = 0; id < idCount; id++) {
      const size_t begin = begins[STREAMS * (size_t)id];
      const size_t size = begins[STREAMS * ((size_t)id + 1)] - begin;
      if (size <= FEW) {
        sortFew(rows + begin, size);
      } else {
        ctSortInts(rows + begin, (int)size);
      }
      for (size_t i = begin; i < begin + size; i++) {
        firsts[i] = id;
        seconds[i] = rows[i];
      }
    }
  }
  free(begins);
  free(rows);
  return hasMemory;
}
