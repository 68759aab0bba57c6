/* Pairs of particles of leaves on the grid, and their exact sums; part of tapekernels_body.h. */
#include "exactsums.h"

/* ---- Grids ---- */

/* Whole steps of the grid, without what is beyond 32 nm; all of this is exact but for the one rounding. */
static void gridSteps(const double x[CT_LEAF_WIDTH], unsigned occupied, int steps[CT_LEAF_WIDTH]) {
  const double shift = 0x1.8p52;
  double shifted[CT_LEAF_WIDTH];
  int64_t bits[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    const double within = x[k] - 32 * rint(x[k] / 32);
    shifted[k] = within * GRID_STEPS + shift;
  }
  memcpy(bits, shifted, sizeof bits);
  const int first = (int)(uint32_t)(uint64_t)bits[__builtin_ctz(occupied)];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    steps[k] = (int)(uint32_t)(uint64_t)bits[k];
  }
  for (unsigned empty = ~occupied & 0xffff; empty != 0; empty &= empty - 1) {
    steps[__builtin_ctz(empty)] = first;
  }
}

/* The box along one axis. */
static void boxSteps(const int steps[CT_LEAF_WIDTH], int* low, int* high) {
  int least = 0;
  int most = 0;
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    const int from = gridDifference(steps[k], steps[0]);
    least = from < least ? from : least;
    most = from > most ? from : most;
  }
  *low = (int)((unsigned)steps[0] + (unsigned)least);
  *high = (int)((unsigned)steps[0] + (unsigned)most);
}

/* True if some particle is not within the reach of the first. */
static bool isBeyondReach(const double x[CT_LEAF_WIDTH], unsigned occupied) {
  const double first = x[__builtin_ctz(occupied)];
  bool isBeyond = false;
  if (occupied == 0xffff) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      isBeyond |= !(fabs(x[k] - first) <= MOST_GRID_REACH);
    }
    return isBeyond;
  }
  for (unsigned left = occupied; left != 0; left &= left - 1) {
    isBeyond = isBeyond || !(fabs(x[__builtin_ctz(left)] - first) <= MOST_GRID_REACH);
  }
  return isBeyond;
}

static void makeGrid(const ctLeafPositions* positions, unsigned occupied, LeafGrid* grid) {
  const double* axes[3] = {positions->x, positions->y, positions->z};
  int* steps[3] = {grid->x, grid->y, grid->z};
  grid->positions = positions;
  grid->isWide = false;
  for (int d = 0; d < 3; d++) {
    gridSteps(axes[d], occupied, steps[d]);
    boxSteps(steps[d], &grid->low[d], &grid->high[d]);
    grid->isWide = isBeyondReach(axes[d], occupied) || grid->isWide;
  }
}

/* ---- Pairs ---- */

CT_INLINE Float16 gridDifference16(Int16 a, int b) {
  return floatsOfInts(subInts(a, allInts(b)));
}

static unsigned rowsOnGrid(const GridPair* pair, const TapeRange* range) {
  const LeafGrid* a = pair->grids[0];
  const LeafGrid* b = pair->grids[1];
  const int* axes[3] = {a->x, a->y, a->z};
  Float16 squared = all16(0);
  for (int d = 0; d < 3; d++) {
    const Int16 x = loadInts(axes[d]);
    const Float16 below = sub16(all16(0), gridDifference16(x, b->low[d]));
    const Float16 apart = max16(max16(below, gridDifference16(x, b->high[d])), all16(0));
    squared = add16(squared, mul16(apart, apart));
  }
  return pair->rows &
         ~greater16(mul16(squared, all16(SQUARED_GRID_STEP)), all16(range->squaredCutoff * ROUNDING_OF_BOXES));
}

/* Lists the pairs that count; returns how many. */
static int listOnGrid(const GridPair* pair, const TapeRange* range, float* squares, int* places, uint16_t* masks) {
  const LeafGrid* a = pair->grids[0];
  const Int16 x = loadInts(pair->grids[1]->x);
  const Int16 y = loadInts(pair->grids[1]->y);
  const Int16 z = loadInts(pair->grids[1]->z);
  /* Read once, not for each row: what is written might be these. */
  const Float16 squaredCutoff = all16(range->squaredCutoff * (1 / SQUARED_GRID_STEP));
  const unsigned occupied = pair->occupied;
  const uint16_t* allowed = pair->allowed;
  int count = 0;
  for (unsigned rows = pair->rows; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 dx = gridDifference16(x, a->x[k]);
    const Float16 dy = gridDifference16(y, a->y[k]);
    const Float16 dz = gridDifference16(z, a->z[k]);
    const Float16 squared = squared16(dx, dy, dz);
    unsigned mask = occupied & greater16(squaredCutoff, squared);
    if (allowed != NULL) {
      mask &= allowed[k];
    }
    masks[k] = (uint16_t)mask;
    count += pack16(mask, squared, CT_LEAF_WIDTH * k, squares + count, places + count);
  }
  return count;
}

/* ---- Sums ---- */

/* Stores what the pairs of a part count. */
static void weighPart(const Tape* tape, const TapeRange* range, const TapePart* part) {
  const float* values = tape->scratch + tape->result.begin;
  const int end = part->begin + (part->pairCount + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
  for (int v = part->begin; v < end; v++) {
    const Float16 value = weighted(tape, range, part, v, load16(values + v * tape->result.step));
    store16(tape->batch->energies + v * CT_LEAF_WIDTH, value);
  }
}

/* What all pairs of the batch count. */
static const float* weighBatch(const Tape* tape, const TapeRange* range) {
  const TapeBatch* batch = tape->batch;
  bool isWeighted = range->hasSwitch || tape->result.step == 0;
  for (int i = 0; i < batch->partCount; i++) {
    isWeighted = isWeighted || batch->parts[i].hasTimes;
  }
  if (!isWeighted) {
    return tape->scratch + tape->result.begin;
  }
  for (int i = 0; i < batch->partCount; i++) {
    weighPart(tape, range, &batch->parts[i]);
  }
  return batch->energies;
}

/* True if no energy of some sixteens is too large or no number. */
static bool areExact(const float* energies, int begin, int end) {
  const Float16 limit = all16(EXACT_LIMIT);
  unsigned exact = 0xffff;
  for (int v = begin; v < end; v++) {
    exact &= greater16(limit, absolute16(load16(energies + v * CT_LEAF_WIDTH)));
  }
  return exact == 0xffff;
}

static int64_t totalOfPart(const TapePart* part, const float* energies) {
  const float* own = energies + part->begin * CT_LEAF_WIDTH;
  const int whole = part->pairCount / CT_LEAF_WIDTH;
  const int rest = part->pairCount % CT_LEAF_WIDTH;
  Exact16 sum = beginExact16(whole + 1);
  for (int v = 0; v < whole; v++) {
    sum = addToExact16(sum, load16(own + v * CT_LEAF_WIDTH));
  }
  return totalOfExact16(addToExact16(sum, keep16((1u << rest) - 1, load16(own + whole * CT_LEAF_WIDTH))));
}

static void sumSections(const TapePart* part, const float* energies, SectionTable* table) {
  const float* packed = energies + part->begin * CT_LEAF_WIDTH;
  *table = (SectionTable){{{0}}};
  for (int s = 0; s < MOST_SECTIONS; s++) {
    unsigned rows = part->rows & part->rowSections->members[s];
    if (rows == 0) {
      continue;
    }
    Exact16 sum = beginExact16(__builtin_popcount(rows));
    for (; rows != 0; rows &= rows - 1) {
      const unsigned mask = part->masks[__builtin_ctz(rows)];
      sum = addToExact16(sum, unpack16(mask, packed));
      packed += __builtin_popcount(mask);
    }
    sumsOfExact16(sum, part->columnSections->members, table->sums[s]);
  }
}

static int64_t totalOfTables(const SectionTable* table, const SectionTable* before, unsigned chosen) {
  const int64_t* sums = table->sums[0];
  const int64_t* sumsBefore = before != NULL ? before->sums[0] : sums;
  const unsigned less = before != NULL ? chosen : 0;
  int64_t total = 0;
  for (int i = 0; i < MOST_SECTIONS * MOST_SECTIONS; i++) {
    total += sums[i] - (sumsBefore[i] & -(int64_t)(less >> i & 1));
  }
  return total;
}

static void finishOnGrid(const Tape* tape, const TapeRange* range) {
  TapeBatch* batch = tape->batch;
  runSteps(tape);
  const float* energies = weighBatch(tape, range);
  const bool allAreExact = areExact(energies, 0, batch->count);
  for (int i = 0; i < batch->partCount; i++) {
    const TapePart* part = &batch->parts[i];
    GridSum* sum = part->sum;
    const int end = part->begin + (part->pairCount + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
    sum->isExact = allAreExact || areExact(energies, part->begin, end);
    if (sum->isExact && sum->table != NULL) {
      sumSections(part, energies, sum->table);
      sum->total = totalOfTables(sum->table, sum->before, sum->chosen);
    } else if (sum->isExact) {
      sum->total = totalOfPart(part, energies);
    }
  }
  empty(batch);
}

/* ---- Adding ---- */

/* Where pairs are whose rows are of the second leaf, as if they were of the first. */
CT_INLINE void swapPlaces(int* places) {
  const Int16 lanes = loadInts(places);
  const Int16 columns = shiftLeftInts(andInts(lanes, allInts(CT_LEAF_WIDTH - 1)), 4);
  storeInts16(places, floatsOfBits(orInts(columns, shiftRightInts(lanes, 4))));
}

static void addNothing(GridSum* sum) {
  sum->isExact = true;
  sum->isEmpty = true;
  sum->total = 0;
  if (sum->table != NULL) {
    *sum->table = (SectionTable){{{0}}};
    sum->total = totalOfTables(sum->table, sum->before, sum->chosen);
  }
}

static void addOnGrid(const Tape* tape, const GridPair* pair, const TapeRange* range, GridSum* sum) {
  TapeBatch* batch = tape->batch;
  if (batch->count + __builtin_popcount(pair->rows) > MOST_SIXTEENS) {
    finishOnGrid(tape, range);
  }
  TapePart* part = &batch->parts[batch->partCount];
  const int begin = batch->count * CT_LEAF_WIDTH;
  int* places = batch->places + begin;
  float* squares = tape->scratch + tape->squaredBegin + begin;
  const int count = listOnGrid(pair, range, squares, places, part->masks);
  if (count == 0) {
    addNothing(sum);
    return;
  }
  sum->isEmpty = false;
  /* What fills the last sixteen has to be as harmless as the others. */
  const int sixteens = (count + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
  store16(squares + count, all16(squares[0]));
  storeInts16(places + count, allInts16(places[0]));
  for (int i = 0; pair->times != NULL && i < sixteens * CT_LEAF_WIDTH; i++) {
    batch->times[begin + i] = (float)pair->times[rowOf(places[i])][places[i] % CT_LEAF_WIDTH];
  }
  const float* first = pair->columns[pair->isSwapped ? 1 : 0];
  const float* second = pair->columns[pair->isSwapped ? 0 : 1];
  for (int i = 0; i < sixteens; i++) {
    const int at = i * CT_LEAF_WIDTH;
    store16(squares + at, mul16(load16(squares + at), all16(SQUARED_GRID_STEP))); /* from steps to nm */
    if (pair->isSwapped) {
      swapPlaces(places + at);
    }
    batch->columns[0][batch->count + i] = first;
    batch->columns[1][batch->count + i] = second;
  }
  part->begin = batch->count;
  part->pairCount = count;
  part->hasTimes = pair->times != NULL;
  part->sum = sum;
  part->rowSections = pair->sections[0];
  part->columnSections = pair->sections[1];
  part->rows = pair->rows;
  batch->partCount++;
  batch->count += sixteens;
}
