#include "gridsums.h"

#include <math.h>
#include <stdlib.h>

#include "exactsums.h"
#include "trialview.h"

bool ctPairSetFitsGrid(const PairSet* set) {
  return set->cutoff < MOST_GRID_CUTOFF && !set->tape.isExact;
}

bool ctGridSumsCreate(GridSums* sums, TrialGrids* grids, PairSet* set) {
  const int leafCount = grids->leaves->leafCount;
  *sums = (GridSums){.grids = grids, .set = set};
  return ctSectionSumsCreate(&sums->sums, leafCount) && ctSectionSumsCreate(&sums->keptSums, leafCount);
}

void ctGridSumsFree(GridSums* sums) {
  ctSectionSumsFree(&sums->sums);
  ctSectionSumsFree(&sums->keptSums);
  free(sums->staged);
  free(sums->tables);
  *sums = (GridSums){0};
}

/* ---- Two leaves ---- */

/* What a pair of leaves has by what was computed, and what was there `before` of what was not. */
static PairSum sumOf(const StagedOnGrid* staged, int64_t before) {
  const GridSum* computed = &staged->computed;
  const PairKnowledge knowledge = computed->table != NULL ? SECTIONS_KNOWN
                                  : computed->isEmpty     ? NOTHING_THERE
                                                          : SUM_KNOWN;
  return (PairSum){knowledge, {.exact = computed->total + before}};
}

/* That of an energy that is computed in double since some pair's is too large, or no number. */
static PairSum inexactSum(const GridSums* sums, const StagedOnGrid* staged, const LeafGrid* a, const LeafGrid* b) {
  return (PairSum){SUM_INEXACT, {.inexact = ctPairSetExactOnGrid(sums->set, staged->a, staged->b, a, b)}};
}

/* ---- The state ---- */

static void finish(GridSums* sums) {
  sums->set->kernels->finishOnGrid(&sums->set->tape, &sums->set->range);
}

/* Keeps the sums of a batch of pairs of leaves of the state. */
static bool keepFew(GridSums* sums, int count, StagedOnGrid* few) {
  bool isKept = true;
  finish(sums);
  for (int i = 0; i < count; i++) {
    StagedOnGrid* pair = &few[i];
    if (pair->computed.isExact) {
      pair->sum = sumOf(pair, 0);
    } else {
      pair->sum = inexactSum(sums, pair, ctStateGrid(sums->grids, pair->a), ctStateGrid(sums->grids, pair->b));
    }
    isKept = isKept && ctSectionSumsSet(&sums->sums, pair->a, pair->b, NOT_KEPT, &pair->sum, NULL, 0, false);
  }
  return isKept;
}

/* Pairs of leaves of the state that are summed at a time. */
enum { FEW_PAIRS = 32 };

ctStatus ctGridSumsRefresh(GridSums* sums, size_t count, const ctLeafPair* near) {
  StagedOnGrid few[FEW_PAIRS];
  int fewCount = 0;
  sums->stagedCount = 0;
  ctSectionSumsClear(&sums->sums);
  for (size_t i = 0; i < count; i++) {
    if (!ctIsWithin(near[i].squaredGap, sums->set->cutoff)) {
      continue;
    }
    if (fewCount == FEW_PAIRS) {
      if (!keepFew(sums, fewCount, few)) {
        return ctOutOfMemory;
      }
      fewCount = 0;
    }
    StagedOnGrid* pair = &few[fewCount++];
    *pair = (StagedOnGrid){.a = near[i].a, .b = near[i].b};
    const LeafOnGrid a = {pair->a, ctStateGrid(sums->grids, pair->a), &sums->grids->sections[pair->a]};
    const LeafOnGrid b = {pair->b, ctStateGrid(sums->grids, pair->b), &sums->grids->sections[pair->b]};
    ctPairSetAddOnGrid(sums->set, &a, &b, 0xffff, false, &pair->computed);
  }
  return keepFew(sums, fewCount, few) ? ctSuccess : ctOutOfMemory;
}

/* ---- Trials ---- */

/* Of trials that change fewer pairs of leaves, what sections have is computed, too, since such trials come back. */
enum { PAIRS_OF_SMALL_TRIALS = 192 };

/* The sections that do not move with the other leaf, which moves as one, as bits. */
static unsigned sectionsThatMove(const LeafSections* sections, const LeafMotion* motion, int bodyOfOther) {
  unsigned moving = 0;
  for (int s = 0; s < MOST_SECTIONS; s++) {
    moving |= sections->members[s] != 0 && motion->sections[s] != bodyOfOther ? 1u << s : 0;
  }
  return moving;
}

static unsigned membersOf(const LeafSections* sections, unsigned chosen) {
  unsigned members = 0;
  for (; chosen != 0; chosen &= chosen - 1) {
    members |= sections->members[__builtin_ctz(chosen)];
  }
  return members;
}

/* Bits of a table: its first row, and its first column. */
#define WHOLE_ROW ((1u << MOST_SECTIONS) - 1)
#define EACH_ROW 0x1111u

_Static_assert(MOST_SECTIONS == 4, "a table has four columns");

/* The numbers of a table that are of some sections of the first leaf, or of the second, as bits. */
static uint16_t numbersOf(unsigned sections, bool isOfSecond) {
  unsigned numbers = 0;
  for (; sections != 0; sections &= sections - 1) {
    const int s = __builtin_ctz(sections);
    numbers |= isOfSecond ? EACH_ROW << s : WHOLE_ROW << MOST_SECTIONS * s;
  }
  return (uint16_t)numbers;
}

/* Finds what moves of a leaf, unless it was the last one that was asked about. */
static const MovingRows* findMovingRows(GridSums* sums, int leaf, const LeafMotion* motion, int bodyOfOther,
                                        bool isSwapped) {
  MovingRows* rows = &sums->lastRows;
  const int64_t trial = sums->grids->leaves->trial;
  if (rows->trial != trial || rows->leaf != leaf || rows->bodyOfOther != bodyOfOther || rows->isSwapped != isSwapped) {
    const LeafSections* sections = &sums->grids->sections[leaf];
    const unsigned moving = sectionsThatMove(sections, motion, bodyOfOther);
    *rows = (MovingRows){trial,
                         leaf,
                         bodyOfOther,
                         isSwapped,
                         (uint8_t)moving,
                         numbersOf(moving, isSwapped),
                         membersOf(sections, moving)};
  }
  return rows;
}

static bool knowsSections(const GridSums* sums, int kept) {
  const PairKnowledge knowledge = kept == NOT_KEPT ? NOTHING_THERE : sums->sums.pairs[kept].sum.knowledge;
  return knowledge == NOTHING_THERE || knowledge == SECTIONS_KNOWN;
}

/* Adds what is to be computed of a changed pair of leaves to the batch. */
static void stagePair(GridSums* sums, const ChangedPair* changed) {
  TrialGrids* grids = sums->grids;
  const int number = sums->stagedCount++;
  StagedOnGrid* staged = &sums->staged[number];
  const LeafMotion* a = trialMotion(grids, changed->a);
  const LeafMotion* b = trialMotion(grids, changed->b);
  const bool isOneMixed = (a->body == MANY_BODIES) != (b->body == MANY_BODIES);
  const bool isSwapped = b->body == MANY_BODIES && a->body != MANY_BODIES;
  const int rowLeaf = isSwapped ? changed->b : changed->a;
  const int columnLeaf = isSwapped ? changed->a : changed->b;
  const LeafSections* sections = &grids->sections[rowLeaf];
  *staged = (StagedOnGrid){.a = changed->a, .b = changed->b, .isSwapped = isSwapped, .changed = WHOLE_ROW};
  /* Of two leaves that move as one, that which moves comes first: it is in more pairs. */
  const bool isFirst = b->body == 0 || (a->body == MANY_BODIES && !isSwapped);
  staged->kept = sectionSumsFind(&sums->sums, isFirst ? changed->a : changed->b, isFirst ? changed->b : changed->a);
  unsigned rows = 0xffff;
  if (isOneMixed && knowsSections(sums, staged->kept)) {
    staged->isPartial = true;
    const MovingRows* moving =
        findMovingRows(sums, rowLeaf, isSwapped ? b : a, isSwapped ? a->body : b->body, isSwapped);
    staged->changed = moving->sections;
    rows = moving->rows;
    const int table = staged->kept != NOT_KEPT ? sums->sums.pairs[staged->kept].table : NOT_KEPT;
    if (table != NOT_KEPT) {
      const SectionTable* before = &sums->sums.tables[table];
      /* It is read when all is computed. */
      __builtin_prefetch(before);
      __builtin_prefetch((const char*)before + sizeof *before - 1);
      staged->computed.before = before;
      staged->computed.chosen = moving->numbers;
    }
  }
  const bool isByOne = a->body != MANY_BODIES && b->body != MANY_BODIES;
  if (!isByOne || grids->leaves->changedCount < PAIRS_OF_SMALL_TRIALS) {
    staged->computed.table = &sums->tables[number];
  }
  const LeafOnGrid rowSide = {rowLeaf, trialGrid(grids, rowLeaf), sections};
  const LeafOnGrid columnSide = {columnLeaf, trialGrid(grids, columnLeaf), &grids->sections[columnLeaf]};
  ctPairSetAddOnGrid(sums->set, &rowSide, &columnSide, rows, isSwapped, &staged->computed);
}

/* Finds the new sum of a pair of leaves once all is computed; returns by how much it changes. */
static double settle(const GridSums* sums, StagedOnGrid* staged) {
  const PairSum nothing = {NOTHING_THERE, {0}};
  const PairSum* before = staged->kept != NOT_KEPT ? &sums->sums.pairs[staged->kept].sum : &nothing;
  if (staged->computed.isExact) {
    staged->sum = sumOf(staged, staged->isPartial ? before->sum.exact : 0);
  } else {
    staged->sum = inexactSum(sums, staged, trialGrid(sums->grids, staged->a), trialGrid(sums->grids, staged->b));
  }
  return changeOf(sumOfPair(before), sumOfPair(&staged->sum));
}

static ctStatus stage(GridSums* sums, bool near, double* change) {
  const TrialLeaves* leaves = sums->grids->leaves;
  const size_t most = (size_t)leaves->changedCount;
  const int begin = sums->stagedCount;
  *change = 0;
  if (!ctReserveEntries((void**)&sums->staged, &sums->stagedCapacity, most, sizeof *sums->staged) ||
      !ctReserveEntries((void**)&sums->tables, &sums->tableCapacity, most, sizeof *sums->tables)) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < leaves->changedCount; i++) {
    const ChangedPair* pair = &leaves->changed[i];
    if (pair->isNear == near && ctIsWithin(pair->squaredGap, sums->set->cutoff)) {
      stagePair(sums, pair);
    }
  }
  finish(sums);
  for (int i = begin; i < sums->stagedCount; i++) {
    *change += settle(sums, &sums->staged[i]);
  }
  return ctSuccess;
}

ctStatus ctGridSumsNearChange(GridSums* sums, double* change) {
  sums->stagedCount = 0;
  return stage(sums, true, change);
}

ctStatus ctGridSumsOtherChange(GridSums* sums, double* change) {
  return stage(sums, false, change);
}

static bool acceptPair(GridSums* sums, const StagedOnGrid* staged) {
  return ctSectionSumsSet(&sums->sums, staged->a, staged->b, staged->kept, &staged->sum, staged->computed.table,
                          staged->changed, staged->isSwapped);
}

bool ctGridSumsAccept(GridSums* sums) {
  bool isKept = true;
  /* Those that are there first: adding may remove some. */
  for (int i = 0; i < sums->stagedCount && isKept; i++) {
    isKept = sums->staged[i].kept == NOT_KEPT || acceptPair(sums, &sums->staged[i]);
  }
  for (int i = 0; i < sums->stagedCount && isKept; i++) {
    isKept = sums->staged[i].kept != NOT_KEPT || acceptPair(sums, &sums->staged[i]);
  }
  sums->stagedCount = 0;
  return isKept;
}

/* ---- Copies ---- */

bool ctGridSumsKeep(GridSums* sums) {
  return ctSectionSumsCopy(&sums->sums, &sums->keptSums);
}

void ctGridSumsTakeBack(GridSums* sums) {
  sums->stagedCount = 0;
  ctSectionSumsCopy(&sums->keptSums, &sums->sums);
}
