/* Trials of the stand-in. */
#include <string.h>

#include "standin.h"

/* ---- Leaves that the trial changes ---- */

static bool isTouched(const StandIn* standIn, int leaf) {
  return standIn->trial[leaf].trial == standIn->leaves->trial;
}

/* A leaf as the trial has it, but for its radii if their sums are to change. */
static StandInLeaf* touch(StandIn* standIn, int leaf, bool bornChanges) {
  StandInLeaf* other = otherLeaf(standIn, leaf);
  if (!isTouched(standIn, leaf)) {
    const StandInLeaf* state = stateLeaf(standIn, leaf);
    memcpy(other->born, state->born, sizeof other->born);
    memcpy(other->gradient, state->gradient, sizeof other->gradient);
    if (!bornChanges) {
      other->radii = state->radii;
    }
    standIn->trial[leaf] = (TrialLeaf){standIn->leaves->trial, 0};
    standIn->touched[standIn->touchedCount++] = leaf;
  }
  return other;
}

static unsigned crossing(const StandIn* standIn, int leaf) {
  return isTouched(standIn, leaf) ? standIn->trial[leaf].crossing : 0;
}

/* A leaf in this frame, with the radii of the trial. */
static PlacedLeaf placeInTrial(const StandIn* standIn, int leaf, const LeafFrame* frame) {
  const StandInLeaf* sums = isTouched(standIn, leaf) ? otherLeaf(standIn, leaf) : stateLeaf(standIn, leaf);
  const bool isCrossed = crossing(standIn, leaf) != 0;
  return (PlacedLeaf){leaf, frame, &sums->radii, isCrossed ? otherShift(standIn, leaf) : stateShift(standIn, leaf)};
}

/* The record of a pair in the state. */
static PairRecord* recordOf(const StandIn* standIn, const StagedPair* staged) {
  return &standIn->neighbors.records[staged->pair];
}

/* The frames of a pair in the trial, or in the state. */
static void findFrames(const StandIn* standIn, const StagedPair* staged, bool inTrial, PairFrames* frames) {
  ctStandInFindFrames(standIn, staged->a, staged->b, recordOf(standIn, staged)->image, inTrial, frames);
}

/* Those in the trial, and those before it. */
static void findBothFrames(const StandIn* standIn, const StagedPair* staged, PairFrames frames[2]) {
  findFrames(standIn, staged, true, &frames[0]);
  findFrames(standIn, staged, false, &frames[1]);
}

/* Replaces the contribution of a pair to the gradients of its leaves. */
static void exchangeGradients(StandIn* standIn, const StagedPair* staged) {
  const PairRecord* before = recordOf(standIn, staged);
  const PairRecord* after = &staged->after;
  if (!before->hasPairs && !after->hasPairs) {
    return;
  }
  const int leaves[2] = {staged->a, staged->b};
  for (int side = 0; side < 2; side++) {
    StandInLeaf* leaf = touch(standIn, leaves[side], false);
    standIn->leaves->wide->exchangeParts(leaf->gradient, gradientOf(before, side), gradientOf(after, side));
  }
}

/* ---- Pairs that move ---- */

/* Ends a former trial that was not accepted, and frees the numbers of its new pairs. */
static void rejectFormer(StandIn* standIn) {
  for (int i = 0; i < standIn->movedCount; i++) {
    if (standIn->staged[i].isNew) {
      ctNeighborsRelease(&standIn->neighbors, standIn->staged[i].pair);
    }
  }
  rejectTrial(standIn);
}

/* Makes room for `count` staged pairs, as ctReserveEntries does, at the begin of a cache line. */
static bool reserveStaged(StandIn* standIn, size_t count) {
  if (count > (size_t)standIn->stagedCapacity) {
    const size_t wanted = count + count / 2;
    if (wanted >= INT32_MAX ||
        !growLines((void**)&standIn->staged, (size_t)standIn->stagedCount, wanted, sizeof *standIn->staged)) {
      return false;
    }
    standIn->stagedCapacity = (int)wanted;
  }
  return true;
}

/* A record is computed again after this many moves of displaced particles, so that rounding does not add up. */
enum { MOST_MOVES = 64 };

/* True if a record has all that displaced particles change. */
static bool canMove(const PairRecord* record, const NearRows* movers) {
  return record->moves < MOST_MOVES && (record->hasPairs || !havePairs(movers)) &&
         (record->hasBorn || !haveBorn(movers));
}

/* Stages the changed pairs that are near, or the others. */
static ctStatus stage(StandIn* standIn, bool near) {
  TrialLeaves* leaves = standIn->leaves;
  if (!reserveStaged(standIn, (size_t)leaves->changedCount)) {
    return ctOutOfMemory;
  }
  int count;
  const ctLeafPair* pairs = ctChangedPairs(leaves, near, &count);
  for (int i = 0; i < count; i++) {
    const ctLeafPair* changed = &pairs[i];
    StagedPair* staged = &standIn->staged[standIn->stagedCount];
    NearRows* rows = &staged->rows;
    PairFrames frames;
    ctStandInFindFrames(standIn, changed->a, changed->b, changed->image, true, &frames);
    if (leaves->isDisplacement) {
      leaves->wide->nearSome(&standIn->farReach, frames.a, frames.b, ctMoversOf(leaves, changed->a),
                             ctMoversOf(leaves, changed->b), rows);
      if (!havePairs(rows) && !haveBorn(rows)) {
        continue;
      }
    }
    /* In the row of a leaf that moves: most pairs of a small move are in that. */
    const int moved = ctHasOwnFrame(leaves, changed->b) ? changed->b : changed->a;
    const int found = ctNeighborsFind(&standIn->neighbors, moved, changed->a + changed->b - moved, changed->image);
    const bool isMove = leaves->isDisplacement && found != CT_NULL && canMove(&standIn->neighbors.records[found], rows);
    if (!isMove) {
      leaves->wide->nearRows(&standIn->model, frames.a, frames.b, rows);
    }
    if (found == CT_NULL && !hasPairs(rows) && !hasBorn(rows)) {
      continue;
    }
    const int pair = found != CT_NULL ? found : ctNeighborsReserve(&standIn->neighbors, changed->image);
    if (pair == CT_NULL) {
      return ctOutOfMemory;
    }
    PairRecord* record = &standIn->neighbors.records[pair];
    fetchPairs(record);
    fetchBorn(record);
    record->trial = leaves->trial;
    standIn->stagedCount++;
    staged->a = changed->a;
    staged->b = changed->b;
    staged->pair = pair;
    staged->isNew = found == CT_NULL;
    staged->isNear = near;
    staged->isOpen = true;
    staged->isMove = isMove;
    standIn->movedCount = standIn->stagedCount;
  }
  return ctSuccess;
}

/* Computes the energy of a pair with the radii of the state. */
static void computePairs(StandIn* standIn, StagedPair* staged, const NearRows* rows) {
  PairFrames frames;
  findFrames(standIn, staged, true, &frames);
  const PlacedLeaf a = ctStandInPlace(standIn, staged->a, frames.a);
  const PlacedLeaf b = ctStandInPlace(standIn, staged->b, frames.b);
  ctStandInComputePairs(standIn, &a, &b, rows, &staged->after);
}

/* kJ/mol. The rounding of a larger change, which a clash makes, would stay in the record. */
#define MOST_CHANGE 1e3

/* Changes the energy of a pair by what displaced particles change, with the radii of the state. */
static void movePairs(StandIn* standIn, StagedPair* staged) {
  const PairRecord* before = recordOf(standIn, staged);
  copyPairs(before, &staged->after);
  staged->after.moves++;
  if (!havePairs(&staged->rows)) {
    return;
  }
  PairFrames frames[2];
  findBothFrames(standIn, staged, frames);
  ctStandInMovePairs(standIn, staged->a, staged->b, frames, &staged->rows, &staged->after);
  if (!(fabs(staged->after.energy - before->energy) < MOST_CHANGE)) {
    NearRows rows;
    standIn->leaves->wide->nearRows(&standIn->model, frames->a, frames->b, &rows);
    computePairs(standIn, staged, &rows);
  }
}

ctStatus ctStandInNearChange(StandIn* standIn, double* change) {
  rejectFormer(standIn);
  if (standIn->leaves->isDisplacement) {
    /* Both leaves of a pair can have displaced particles. */
    standIn->farReach = ctStandInReach(&standIn->model, 2 * (float)standIn->leaves->farthest);
  }
  *change = 0;
  if (stage(standIn, true) != ctSuccess) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < standIn->stagedCount; i++) {
    StagedPair* staged = &standIn->staged[i];
    if (staged->isMove) {
      movePairs(standIn, staged);
    } else {
      computePairs(standIn, staged, &staged->rows);
    }
    staged->isOpen = false;
    *change += staged->after.energy - recordOf(standIn, staged)->energy;
  }
  standIn->nearChange = *change;
  return ctSuccess;
}

/* ---- Radii ---- */

/* Changes the Born sums of a pair by what displaced particles change. */
static void moveBorn(StandIn* standIn, StagedPair* staged) {
  PairFrames frames[2];
  findBothFrames(standIn, staged, frames);
  copyBorn(recordOf(standIn, staged), &staged->after);
  ctStandInMoveBorn(standIn, staged->a, staged->b, frames, &staged->rows, &staged->after);
}

static void changeBornSums(StandIn* standIn) {
  for (int i = 0; i < standIn->movedCount; i++) {
    StagedPair* staged = &standIn->staged[i];
    const PairRecord* before = recordOf(standIn, staged);
    PairRecord* after = &staged->after;
    if (staged->isMove && !haveBorn(&staged->rows)) {
      after->hasBorn = before->hasBorn;
      continue;
    }
    if (staged->isMove) {
      moveBorn(standIn, staged);
    } else {
      PairFrames frames;
      findFrames(standIn, staged, true, &frames);
      ctStandInComputeBorn(standIn, staged->a, frames.a, staged->b, frames.b, &staged->rows, after);
    }
    const int leaves[2] = {staged->a, staged->b};
    for (int side = 0; side < 2 && (before->hasBorn || after->hasBorn); side++) {
      const float* from = bornOf(before, side);
      const float* to = bornOf(after, side);
      /* Many leaves are near by their boxes alone. */
      if (memcmp(from, to, sizeof after->born[side]) != 0) {
        StandInLeaf* leaf = touch(standIn, leaves[side], true);
        standIn->leaves->wide->exchangeParts(leaf->born, from, to);
      }
    }
  }
}

static void changeRadii(StandIn* standIn) {
  for (int i = 0; i < standIn->touchedCount; i++) {
    const int leaf = standIn->touched[i];
    StandInLeaf* other = otherLeaf(standIn, leaf);
    const StandInLeaf* state = stateLeaf(standIn, leaf);
    unsigned crossing = 0;
    ctStandInComputeRadii(standIn, leaf, other);
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      crossing |= (unsigned)(other->radii.log[k] != state->radii.log[k]) << k;
    }
    standIn->trial[leaf].crossing = crossing;
    if (crossing != 0) {
      standIn->leaves->wide->standInShift(&standIn->model, standIn->born.columns[leaf].charge, &other->radii,
                                          otherShift(standIn, leaf));
    }
  }
}

/* ---- Energies with these radii ---- */

/* Replaces in a record the energies of particles whose radii change by those with the radii of the trial, at positions
 * of the trial or of the state. */
static void exchangeRadii(StandIn* standIn, const StagedPair* staged, bool inTrial, PairRecord* record) {
  PairFrames frames;
  findFrames(standIn, staged, inTrial, &frames);
  const PlacedLeaf a = placeInTrial(standIn, staged->a, frames.a);
  const PlacedLeaf b = placeInTrial(standIn, staged->b, frames.b);
  ctStandInExchangePairs(standIn, &a, crossing(standIn, staged->a), &b, crossing(standIn, staged->b), record);
}

/* Computes the energies of moved pairs that are not known yet. Returns the change of the energy of all moved pairs. */
static double changeMovedPairs(StandIn* standIn) {
  double change = 0;
  double nearBack = 0;
  for (int i = 0; i < standIn->movedCount; i++) {
    StagedPair* staged = &standIn->staged[i];
    const PairRecord* before = recordOf(standIn, staged);
    PairRecord* after = &staged->after;
    const bool isCrossed = (crossing(standIn, staged->a) | crossing(standIn, staged->b)) != 0;
    double back = before->energy;
    if (staged->isNear && isCrossed && before->hasPairs) {
      PairRecord record;
      copyPairs(before, &record);
      exchangeRadii(standIn, staged, false, &record);
      back = record.energy;
    }
    if (staged->isOpen && staged->isMove) {
      movePairs(standIn, staged);
    } else if (staged->isOpen) {
      PairFrames frames;
      findFrames(standIn, staged, true, &frames);
      const PlacedLeaf a = placeInTrial(standIn, staged->a, frames.a);
      const PlacedLeaf b = placeInTrial(standIn, staged->b, frames.b);
      ctStandInComputePairs(standIn, &a, &b, &staged->rows, after);
    }
    if (isCrossed && (staged->isMove || !staged->isOpen)) {
      exchangeRadii(standIn, staged, true, after);
    }
    if (staged->isNear) {
      nearBack += back - after->energy;
    }
    change += after->energy - before->energy;
    if (isCrossed || !staged->isMove || havePairs(&staged->rows)) {
      exchangeGradients(standIn, staged);
    }
  }
  standIn->nearChangeBack = nearBack;
  return change;
}

/* The change of a pair that does not move. */
static double changeUnmovedPair(StandIn* standIn, StagedPair* staged) {
  const PairRecord* before = recordOf(standIn, staged);
  PairRecord* after = &staged->after;
  copyPairs(before, after);
  exchangeRadii(standIn, staged, false, after);
  exchangeGradients(standIn, staged);
  return after->energy - before->energy;
}

/* Pairs of a row are prefetched this far ahead: records of large proteins do not fit into the cache. */
enum { FETCHED_AHEAD = 4 };

/* Changes the pairs that do not move, but have particles with other radii. */
static ctStatus changeUnmovedPairs(StandIn* standIn, double* change) {
  Neighbors* neighbors = &standIn->neighbors;
  /* Leaves that are touched from here on have the radii of the state. */
  const int count = standIn->touchedCount;
  for (int i = 0; i < count; i++) {
    const int leaf = standIn->touched[i];
    const NeighborRow* row = &neighbors->rows[leaf];
    if (standIn->trial[leaf].crossing == 0) {
      continue;
    }
    if (!reserveStaged(standIn, (size_t)standIn->stagedCount + (size_t)row->count)) {
      return ctOutOfMemory;
    }
    for (int n = 0; n < row->count; n++) {
      const int other = row->leaves[n];
      const int pair = row->pairs[n];
      PairRecord* record = &neighbors->records[pair];
      if (n + FETCHED_AHEAD < row->count) {
        fetchPairs(&neighbors->records[row->pairs[n + FETCHED_AHEAD]]);
      }
      if (record->trial != standIn->leaves->trial && record->hasPairs) {
        record->trial = standIn->leaves->trial;
        StagedPair* staged = &standIn->staged[standIn->stagedCount++];
        staged->a = leaf < other ? leaf : other;
        staged->b = leaf < other ? other : leaf;
        staged->pair = pair;
        staged->isMove = false;
        *change += changeUnmovedPair(standIn, staged);
      }
    }
  }
  return ctSuccess;
}

ctStatus ctStandInOtherChange(StandIn* standIn, double* change) {
  const Wide* wide = standIn->leaves->wide;
  if (stage(standIn, false) != ctSuccess) {
    return ctOutOfMemory;
  }
  changeBornSums(standIn);
  changeRadii(standIn);
  double total = changeMovedPairs(standIn);
  if (changeUnmovedPairs(standIn, &total) != ctSuccess) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < standIn->touchedCount; i++) {
    const int leaf = standIn->touched[i];
    StandInLeaf* other = otherLeaf(standIn, leaf);
    other->energy = wide->standInLeafEnergy(&other->radii, other->gradient);
    total += other->energy - stateLeaf(standIn, leaf)->energy;
  }
  *change = total - standIn->nearChange;
  return ctSuccess;
}

/* ---- The end of a trial ---- */

/* Makes the trial's record of a moved pair that of the state, or removes the pair if its record is empty. */
static bool acceptMovedPair(Neighbors* neighbors, const StagedPair* staged) {
  const PairRecord* after = &staged->after;
  if (!after->hasPairs && !after->hasBorn) {
    if (!staged->isNew) {
      ctNeighborsRemove(neighbors, staged->a, staged->b, staged->pair);
    }
    ctNeighborsRelease(neighbors, staged->pair);
    return true;
  }
  copyPairs(after, &neighbors->records[staged->pair]);
  if (!staged->isMove || haveBorn(&staged->rows)) {
    copyBorn(after, &neighbors->records[staged->pair]);
  }
  return !staged->isNew || ctNeighborsAdd(neighbors, staged->a, staged->b, staged->pair);
}

bool ctStandInAccept(StandIn* standIn) {
  bool isDone = true;
  for (int i = 0; i < standIn->movedCount; i++) {
    isDone = acceptMovedPair(&standIn->neighbors, &standIn->staged[i]) && isDone;
  }
  for (int i = standIn->movedCount; i < standIn->stagedCount; i++) {
    copyPairs(&standIn->staged[i].after, recordOf(standIn, &standIn->staged[i]));
  }
  for (int i = 0; i < standIn->touchedCount; i++) {
    const int leaf = standIn->touched[i];
    standIn->present[leaf] ^= 1;
    standIn->presentShift[leaf] ^= standIn->trial[leaf].crossing != 0;
  }
  rejectTrial(standIn);
  return isDone;
}
