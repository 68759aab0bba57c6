/* Trials of the stand-in. */
#include <string.h>

#include "standin.h"

/* ---- Leaves that the trial changes ---- */

static bool isTouched(const StandIn* standIn, int leaf) {
  return standIn->trial[leaf].stamp == standIn->leaves->trial;
}

/* A leaf as the trial has it. */
static TrialLeaf* touch(StandIn* standIn, int leaf) {
  TrialLeaf* trial = &standIn->trial[leaf];
  if (!isTouched(standIn, leaf)) {
    trial->leaf = standIn->state[leaf];
    trial->stamp = standIn->leaves->trial;
    trial->bornChanges = false;
    trial->crossing = 0;
    standIn->touched[standIn->touchedCount++] = leaf;
  }
  return trial;
}

static const StandInRadii* trialRadii(const StandIn* standIn, int leaf) {
  return isTouched(standIn, leaf) ? &standIn->trial[leaf].leaf.radii : &standIn->state[leaf].radii;
}

static unsigned crossing(const StandIn* standIn, int leaf) {
  return isTouched(standIn, leaf) ? standIn->trial[leaf].crossing : 0;
}

/* Replaces parts of sums by others. */
static void replace(double* sums, const float* before, const float* after) {
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] += (double)after[k] - (double)before[k];
  }
}

/* ---- Pairs that move ---- */

/* Gives numbers back that a former trial took and that were not accepted. */
static void forget(StandIn* standIn) {
  for (int i = 0; i < standIn->movedCount; i++) {
    if (standIn->staged[i].isNew) {
      ctNeighborsRelease(&standIn->neighbors, standIn->staged[i].pair);
    }
  }
  standIn->stagedCount = 0;
  standIn->movedCount = 0;
  standIn->touchedCount = 0;
}

/* Stages the changed pairs that are near, or the others. */
static ctStatus stage(StandIn* standIn, bool near) {
  const TrialLeaves* leaves = standIn->leaves;
  if (!ctReserveEntries((void**)&standIn->staged, &standIn->stagedCapacity, (size_t)leaves->changedCount,
                        sizeof *standIn->staged)) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < leaves->changedCount; i++) {
    const ChangedPair* changed = &leaves->changed[i];
    const bool hasBorn = ctIsWithin(changed->squaredGap, standIn->bornCutoff);
    if (changed->isNear != near || !(hasBorn || ctIsWithin(changed->squaredGap, standIn->pairCutoff))) {
      continue;
    }
    const int found = ctNeighborsFind(&standIn->neighbors, changed->a, changed->b);
    const int pair = found != CT_NULL ? found : ctNeighborsReserve(&standIn->neighbors);
    if (pair == CT_NULL) {
      return ctOutOfMemory;
    }
    standIn->neighbors.stamp[pair] = leaves->trial;
    standIn->staged[standIn->stagedCount++] =
        (StagedPair){changed->a, changed->b, pair, found == CT_NULL, near, true, hasBorn};
    standIn->movedCount = standIn->stagedCount;
  }
  return ctSuccess;
}

/* Computes the energy of a staged pair in the trial, with radii of the state or of the trial. */
static void computePairs(StandIn* standIn, const StagedPair* staged, bool radiiOfTrial) {
  const int a = staged->a;
  const int b = staged->b;
  const StandInRadii* radiiA = radiiOfTrial ? trialRadii(standIn, a) : &standIn->state[a].radii;
  const StandInRadii* radiiB = radiiOfTrial ? trialRadii(standIn, b) : &standIn->state[b].radii;
  const LeafFrame* frameA = ctTrialFrame(standIn->leaves, a);
  ctStandInComputePairs(standIn, a, frameA, radiiA, b, ctTrialFrame(standIn->leaves, b), radiiB,
                        otherRecord(&standIn->neighbors, staged->pair));
}

ctStatus ctStandInNearChange(StandIn* standIn, double* change) {
  forget(standIn);
  *change = 0;
  if (stage(standIn, true) != ctSuccess) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < standIn->stagedCount; i++) {
    StagedPair* staged = &standIn->staged[i];
    computePairs(standIn, staged, false);
    staged->isOpen = false;
    *change +=
        otherRecord(&standIn->neighbors, staged->pair)->energy - stateRecord(&standIn->neighbors, staged->pair)->energy;
  }
  standIn->nearChange = *change;
  return ctSuccess;
}

/* ---- Radii ---- */

static void changeBornSums(StandIn* standIn) {
  for (int i = 0; i < standIn->movedCount; i++) {
    const StagedPair* staged = &standIn->staged[i];
    const PairRecord* before = stateRecord(&standIn->neighbors, staged->pair);
    PairRecord* after = otherRecord(&standIn->neighbors, staged->pair);
    if (!staged->hasBorn) {
      memset(after->born, 0, sizeof after->born);
      continue;
    }
    const LeafFrame* frameA = ctTrialFrame(standIn->leaves, staged->a);
    ctStandInComputeBorn(standIn, staged->a, frameA, staged->b, ctTrialFrame(standIn->leaves, staged->b), after);
    if (memcmp(before->born, after->born, sizeof after->born) != 0) {
      const int leaves[2] = {staged->a, staged->b};
      for (int side = 0; side < 2; side++) {
        TrialLeaf* trial = touch(standIn, leaves[side]);
        trial->bornChanges = true;
        replace(trial->leaf.born, before->born[side], after->born[side]);
      }
    }
  }
}

static void changeRadii(StandIn* standIn) {
  for (int i = 0; i < standIn->touchedCount; i++) {
    const int leaf = standIn->touched[i];
    TrialLeaf* trial = &standIn->trial[leaf];
    ctStandInComputeRadii(standIn, leaf, &trial->leaf);
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      trial->crossing |= (unsigned)(trial->leaf.radii.number[k] != standIn->state[leaf].radii.number[k]) << k;
    }
    if (trial->crossing != 0) {
      standIn->leaves->kernels->standInShift(&standIn->model, &trial->leaf.radii);
    }
  }
}

/* ---- Energies with these radii ---- */

/* The energy that a near pair has before the trial, but with the radii of the trial. */
static double energyBack(StandIn* standIn, const StagedPair* staged) {
  PairRecord record;
  const int a = staged->a;
  const int b = staged->b;
  const LeafFrame* frameA = ctStateFrame(standIn->leaves, a);
  ctStandInComputePairs(standIn, a, frameA, trialRadii(standIn, a), b, ctStateFrame(standIn->leaves, b),
                        trialRadii(standIn, b), &record);
  return staged->isNew ? 0 : record.energy;
}

/* Computes what is still to be computed of pairs that move. Returns by how much their energy changes. */
static double changeMovedPairs(StandIn* standIn) {
  double change = 0;
  double nearBack = 0;
  for (int i = 0; i < standIn->movedCount; i++) {
    const StagedPair* staged = &standIn->staged[i];
    const PairRecord* before = stateRecord(&standIn->neighbors, staged->pair);
    const PairRecord* after = otherRecord(&standIn->neighbors, staged->pair);
    const bool isCrossed = (crossing(standIn, staged->a) | crossing(standIn, staged->b)) != 0;
    double back = before->energy;
    if (staged->isNear && isCrossed) {
      back = energyBack(standIn, staged);
    }
    if (staged->isOpen || isCrossed) {
      computePairs(standIn, staged, true);
    }
    if (staged->isNear) {
      nearBack += back - after->energy;
    }
    change += after->energy - before->energy;
    replace(touch(standIn, staged->a)->leaf.gradient, before->gradient[0], after->gradient[0]);
    replace(touch(standIn, staged->b)->leaf.gradient, before->gradient[1], after->gradient[1]);
  }
  standIn->nearChangeBack = nearBack;
  return change;
}

/* Exchanges what some particles of an unmoved pair have by what they have with the radii of the trial. */
static double changeUnmovedPair(StandIn* standIn, const StagedPair* staged) {
  const PairRecord* before = stateRecord(&standIn->neighbors, staged->pair);
  PairRecord* after = otherRecord(&standIn->neighbors, staged->pair);
  const int a = staged->a;
  const int b = staged->b;
  const LeafFrame* frameA = ctStateFrame(standIn->leaves, a);
  const LeafFrame* frameB = ctStateFrame(standIn->leaves, b);
  memcpy(after, before, sizeof *after);
  ctStandInExchangePairs(standIn, a, frameA, trialRadii(standIn, a), crossing(standIn, a), b, frameB,
                         trialRadii(standIn, b), crossing(standIn, b), after);
  replace(touch(standIn, a)->leaf.gradient, before->gradient[0], after->gradient[0]);
  replace(touch(standIn, b)->leaf.gradient, before->gradient[1], after->gradient[1]);
  return after->energy - before->energy;
}

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
    if (!ctReserveEntries((void**)&standIn->staged, &standIn->stagedCapacity,
                          (size_t)standIn->stagedCount + (size_t)row->count, sizeof *standIn->staged)) {
      return ctOutOfMemory;
    }
    for (int n = 0; n < row->count; n++) {
      const int other = row->leaves[n];
      const int pair = row->pairs[n];
      if (neighbors->stamp[pair] != standIn->leaves->trial) {
        neighbors->stamp[pair] = standIn->leaves->trial;
        StagedPair* staged = &standIn->staged[standIn->stagedCount++];
        *staged = (StagedPair){.a = leaf < other ? leaf : other, .b = leaf < other ? other : leaf, .pair = pair};
        *change += changeUnmovedPair(standIn, staged);
      }
    }
  }
  return ctSuccess;
}

ctStatus ctStandInOtherChange(StandIn* standIn, double* change) {
  const Kernels* kernels = standIn->leaves->kernels;
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
    StandInLeaf* trial = &standIn->trial[leaf].leaf;
    trial->energy = kernels->standInLeafEnergy(&trial->radii, trial->gradient);
    total += trial->energy - standIn->state[leaf].energy;
  }
  *change = total - standIn->nearChange;
  return ctSuccess;
}

/* ---- The end of a trial ---- */

static bool isEmpty(const PairRecord* record) {
  static const PairRecord empty;
  return memcmp(record, &empty, sizeof empty) == 0;
}

/* Makes the record of the trial that of the state, if it is worth keeping. */
static bool acceptPair(Neighbors* neighbors, const StagedPair* staged) {
  if (isEmpty(otherRecord(neighbors, staged->pair))) {
    if (!staged->isNew) {
      ctNeighborsRemove(neighbors, staged->a, staged->b);
    }
    ctNeighborsRelease(neighbors, staged->pair);
    return true;
  }
  neighbors->present[staged->pair] ^= 1;
  return !staged->isNew || ctNeighborsAdd(neighbors, staged->a, staged->b, staged->pair);
}

bool ctStandInAccept(StandIn* standIn) {
  bool isKept = true;
  for (int i = 0; i < standIn->stagedCount; i++) {
    isKept = acceptPair(&standIn->neighbors, &standIn->staged[i]) && isKept;
  }
  for (int i = 0; i < standIn->touchedCount; i++) {
    standIn->state[standIn->touched[i]] = standIn->trial[standIn->touched[i]].leaf;
  }
  standIn->stagedCount = 0;
  standIn->movedCount = 0;
  standIn->touchedCount = 0;
  return isKept;
}
