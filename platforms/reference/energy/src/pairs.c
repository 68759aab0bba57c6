#include "pairs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"
#include "leafsums.h"
#include "pairmask.h"

/* A pair of leaves in a trial. */
typedef struct StagedSum {
  int a;
  int b;
  int kept; /* where the sum of the state is; see ctLeafSumsFind */
  bool isNear;
  double sum; /* in the trial */
} StagedSum;

/* What the frames of a trial are made from; they are the scene's, as long as the trial is open. */
typedef struct TrialPositions {
  const ctLeafPositions* state;
  const ctLeafPositions* trial;
} TrialPositions;

struct Pairs {
  ctChainTree* tree;
  const Kernels* kernels;
  Potential potential;
  double cutoff;
  int leafCount;
  LeafColumns* columns; /* per leaf, as the three below */
  LeafFrame* frames;    /* of the state */
  bool* frameIsStale;
  LeafFrame* trialFrames;
  int64_t* trialStamp;            /* per leaf: the trial in which frameInTrial was found */
  const LeafFrame** frameInTrial; /* one of the two above */
  PairMask mask;
  LeafSums sums;

  /* The last trial that was asked about. */
  int64_t trial;
  TrialPositions positions;
  int stagedCount;
  int stagedCapacity;
  StagedSum* staged;
  int pieceCount;
  int pieceCapacity;
  ctPiece* pieces;
};

/* ---- Life ---- */

static ctStatus failOutOfMemory(char* errorText, size_t errorSize) {
  snprintf(errorText, errorSize, "out of memory");
  return ctOutOfMemory;
}

/* Writes what is wrong with a description; false if nothing is. */
static bool isWrong(int particleCount, const ctNonbonded* d, const int* slotOf, char* errorText, size_t errorSize) {
  for (int i = 0; i < particleCount; i++) {
    if (slotOf[i] == CT_NULL) {
      return snprintf(errorText, errorSize, "particle %d stands in no leaf", i) > 0;
    }
    if (!isfinite(d->charges[i]) || !isfinite(d->sigmas[i]) || !isfinite(d->epsilons[i]) || d->epsilons[i] < 0) {
      return snprintf(errorText, errorSize,
                      "the charge, sigma or epsilon of particle %d is not finite, or its epsilon is negative", i) > 0;
    }
  }
  for (int i = 0; i < d->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      if (d->exclusions[i][k] < 0 || d->exclusions[i][k] >= particleCount) {
        return snprintf(errorText, errorSize, "exclusion %d names particle %d, but there are %d particles", i,
                        d->exclusions[i][k], particleCount) > 0;
      }
    }
  }
  if (!(d->cutoff > 0)) {
    return snprintf(errorText, errorSize, "the cutoff is %g nm, but has to be above 0", d->cutoff) > 0;
  }
  return false;
}

static void setPotential(Potential* p, const ctNonbonded* d) {
  p->hasCutoff = isfinite(d->cutoff);
  p->hasSwitch = p->hasCutoff && d->switchingDistance < d->cutoff;
  p->exact[0] = p->hasCutoff ? d->cutoff * d->cutoff : INFINITY;
  if (p->hasCutoff) {
    const double both = 2 * d->dielectric + 1;
    p->exact[1] = (d->dielectric - 1) / (both * d->cutoff * d->cutoff * d->cutoff);
    p->exact[2] = 3 * d->dielectric / (both * d->cutoff);
  }
  if (p->hasSwitch) {
    p->exact[3] = d->switchingDistance;
    p->exact[4] = 1 / (d->cutoff - d->switchingDistance);
  }
  /* Without a cutoff, this one tells particles from slots without any. */
  p->squaredCutoff = p->hasCutoff ? (float)p->exact[0] : NOWHERE * NOWHERE / 100;
  p->k = (float)p->exact[1];
  p->c = (float)p->exact[2];
  p->switchingDistance = (float)p->exact[3];
  p->inverseSwitchWidth = (float)p->exact[4];
}

static void setColumns(Pairs* pairs, int particleCount, const ctNonbonded* d, const int* slotOf) {
  for (int i = 0; i < particleCount; i++) {
    LeafColumns* columns = &pairs->columns[slotOf[i] / CT_LEAF_WIDTH];
    const int k = slotOf[i] % CT_LEAF_WIDTH;
    columns->charge[k] = (float)(sqrt(CT_COULOMB) * d->charges[i]);
    columns->sigma[k] = (float)(d->sigmas[i] / 2);
    columns->epsilon[k] = (float)(2 * sqrt(d->epsilons[i]));
    columns->occupied |= 1u << k;
  }
}

ctStatus ctPairsCreate(ctChainTree* tree, int particleCount, const ctNonbonded* nonbonded, const int* slotOf,
                       Pairs** pairs, char* errorText, size_t errorSize) {
  *pairs = NULL;
  if (isWrong(particleCount, nonbonded, slotOf, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  Pairs* made = calloc(1, sizeof *made);
  if (made == NULL) {
    return failOutOfMemory(errorText, errorSize);
  }
  const int leafCount = ctGetLeafCount(tree);
  const size_t leaves = (size_t)leafCount + 1;
  made->tree = tree;
  made->kernels = ctFindKernels(ctGetInstructionSet(tree));
  made->cutoff = nonbonded->cutoff;
  made->leafCount = leafCount;
  made->columns = calloc(leaves, sizeof *made->columns);
  made->frames = calloc(leaves, sizeof *made->frames);
  made->frameIsStale = calloc(leaves, sizeof *made->frameIsStale);
  made->trialFrames = calloc(leaves, sizeof *made->trialFrames);
  made->trialStamp = calloc(leaves, sizeof *made->trialStamp);
  made->frameInTrial = calloc(leaves, sizeof *made->frameInTrial);
  if (made->columns == NULL || made->frames == NULL || made->frameIsStale == NULL || made->trialFrames == NULL ||
      made->trialStamp == NULL || made->frameInTrial == NULL ||
      !ctPairMaskCreate(&made->mask, leafCount, nonbonded->exclusionCount, nonbonded->exclusions, slotOf) ||
      !ctLeafSumsCreate(&made->sums, leafCount)) {
    ctPairsDestroy(made);
    return failOutOfMemory(errorText, errorSize);
  }
  setPotential(&made->potential, nonbonded);
  setColumns(made, particleCount, nonbonded, slotOf);
  *pairs = made;
  return ctSuccess;
}

void ctPairsDestroy(Pairs* pairs) {
  if (pairs != NULL) {
    free(pairs->columns);
    free(pairs->frames);
    free(pairs->frameIsStale);
    free(pairs->trialFrames);
    free(pairs->trialStamp);
    free(pairs->frameInTrial);
    free(pairs->staged);
    free(pairs->pieces);
    ctPairMaskFree(&pairs->mask);
    ctLeafSumsFree(&pairs->sums);
    free(pairs);
  }
}

/* ---- Energies ---- */

/* The energy of two leaves in double precision, for particles so near that single precision overflows. */
static double exactEnergy(const Pairs* pairs, const LeafSide* a, const LeafSide* b) {
  const double* exact = pairs->potential.exact;
  double sum = 0;
  for (unsigned rows = a->columns->occupied; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    unsigned others = b->columns->occupied & ~(a->excluded != NULL ? (unsigned)a->excluded[k] : 0);
    for (; others != 0; others &= others - 1) {
      const int l = __builtin_ctz(others);
      const double x = b->frame->centre[0] - a->frame->centre[0] + (double)b->frame->x[l] - (double)a->frame->x[k];
      const double y = b->frame->centre[1] - a->frame->centre[1] + (double)b->frame->y[l] - (double)a->frame->y[k];
      const double z = b->frame->centre[2] - a->frame->centre[2] + (double)b->frame->z[l] - (double)a->frame->z[k];
      const double squared = x * x + y * y + z * z;
      if (!(squared < exact[0])) {
        continue;
      }
      const double distance = sqrt(squared);
      const double ratio = ((double)a->columns->sigma[k] + (double)b->columns->sigma[l]) / distance;
      const double ratio6 = ratio * ratio * ratio * ratio * ratio * ratio;
      double energy = (double)a->columns->epsilon[k] * (double)b->columns->epsilon[l] * ratio6 * (ratio6 - 1);
      if (pairs->potential.hasSwitch && distance > exact[3]) {
        const double t = (distance - exact[3]) * exact[4];
        energy *= 1 + t * t * t * (-10 + t * (15 - t * 6));
      }
      sum += energy + (double)a->columns->charge[k] * (double)b->columns->charge[l] *
                          (1 / distance + exact[1] * squared - exact[2]);
    }
  }
  return sum;
}

/* The energy of leaves a <= b with these frames. */
static double pairEnergy(const Pairs* pairs, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB) {
  const uint16_t* excluded = pairMaskOf(&pairs->mask, a, b);
  const LeafSide sideA = {frameA, &pairs->columns[a], excluded};
  const LeafSide sideB = {frameB, &pairs->columns[b], excluded != NULL ? pairMaskOf(&pairs->mask, b, a) : NULL};
  const double energy = pairs->kernels->leafPairEnergy(&pairs->potential, &sideA, &sideB);
  return isfinite(energy) ? energy : exactEnergy(pairs, &sideA, &sideB);
}

/* ---- The state ---- */

static const LeafFrame* stateFrame(Pairs* pairs, const ctLeafPositions* state, int leaf) {
  if (pairs->frameIsStale[leaf]) {
    pairs->frameIsStale[leaf] = false;
    pairs->kernels->makeFrame(&state[leaf], pairs->columns[leaf].occupied, &pairs->frames[leaf]);
  }
  return &pairs->frames[leaf];
}

ctStatus ctPairsRefresh(Pairs* pairs, ctCounts* counts) {
  size_t count;
  const ctLeafPair* near;
  const ctLeafPositions* state = ctGetLeaves(pairs->tree);
  pairs->stagedCount = 0;
  ctLeafSumsClear(&pairs->sums);
  if (state == NULL || ctGetLeafPairs(pairs->tree, pairs->cutoff, &count, &near, counts) != ctSuccess) {
    return ctOutOfMemory;
  }
  for (int leaf = 0; leaf < pairs->leafCount; leaf++) {
    pairs->frameIsStale[leaf] = true;
  }
  for (size_t i = 0; i < count; i++) {
    const int a = near[i].a;
    const int b = near[i].b;
    const double sum = pairEnergy(pairs, a, stateFrame(pairs, state, a), b, stateFrame(pairs, state, b));
    if (!ctLeafSumsAdd(&pairs->sums, a, b, sum)) {
      return ctOutOfMemory;
    }
  }
  return ctSuccess;
}

double ctPairsSum(const Pairs* pairs) {
  return ctLeafSumsTotal(&pairs->sums);
}

/* ---- Trials ---- */

static bool reserve(void** array, int* capacity, size_t count, size_t size) {
  if (count > (size_t)*capacity) {
    const size_t wanted = count + count / 2;
    void* grown = wanted < INT32_MAX ? realloc(*array, wanted * size) : NULL;
    if (grown == NULL) {
      return false;
    }
    *array = grown;
    *capacity = (int)wanted;
  }
  return true;
}

/* True if some slots of a leaf move in the trial. */
static bool leafMoves(const Pairs* pairs, int leaf) {
  const int begin = leaf * CT_LEAF_WIDTH;
  const ctPiece* piece = findPiece(pairs->pieces, pairs->pieceCount, begin + CT_LEAF_WIDTH - 1);
  while (piece->body == 0 && piece->slotBegin > begin) {
    piece--;
  }
  return piece->body != 0;
}

static const LeafFrame* trialFrame(Pairs* pairs, int leaf) {
  if (pairs->trialStamp[leaf] != pairs->trial) {
    pairs->trialStamp[leaf] = pairs->trial;
    if (leafMoves(pairs, leaf)) {
      LeafFrame* frame = &pairs->trialFrames[leaf];
      pairs->kernels->makeFrame(&pairs->positions.trial[leaf], pairs->columns[leaf].occupied, frame);
      pairs->frameInTrial[leaf] = frame;
    } else {
      pairs->frameInTrial[leaf] = stateFrame(pairs, pairs->positions.state, leaf);
    }
  }
  return pairs->frameInTrial[leaf];
}

/* Computes the sums of those staged pairs that are near, or of the others, and by how much these change. */
static double computeStaged(Pairs* pairs, bool near) {
  double change = 0;
  for (int i = 0; i < pairs->stagedCount; i++) {
    StagedSum* staged = &pairs->staged[i];
    if (staged->isNear == near) {
      const LeafFrame* a = trialFrame(pairs, staged->a);
      const LeafFrame* b = trialFrame(pairs, staged->b);
      staged->sum = pairEnergy(pairs, staged->a, a, staged->b, b);
      staged->kept = ctLeafSumsFind(&pairs->sums, staged->a, staged->b);
      const double before = staged->kept != ABSENT ? pairs->sums.rows[staged->a].sums[staged->kept] : 0;
      change += changeOf(before, staged->sum);
    }
  }
  return change;
}

/* Finds the pairs of leaves that the open trial changes. */
static ctStatus stage(Pairs* pairs, ctCounts* counts) {
  size_t count;
  const ctLeafPair* changed;
  const ctPiece* pieces;
  const ctTransform* motions;
  TrialPositions* positions = &pairs->positions;
  pairs->stagedCount = 0;
  positions->state = ctGetLeaves(pairs->tree);
  const ctStatus status =
      ctGetChangedLeafPairs(pairs->tree, pairs->cutoff, &count, &changed, &positions->trial, counts);
  if (positions->state == NULL || status != ctSuccess) {
    return status != ctSuccess ? status : ctOutOfMemory;
  }
  const int pieceCount = ctGetTrialPieces(pairs->tree, &pieces, &motions);
  if (!reserve((void**)&pairs->staged, &pairs->stagedCapacity, count, sizeof *pairs->staged) ||
      !reserve((void**)&pairs->pieces, &pairs->pieceCapacity, (size_t)pieceCount, sizeof *pairs->pieces)) {
    return ctOutOfMemory;
  }
  memcpy(pairs->pieces, pieces, (size_t)pieceCount * sizeof *pieces);
  pairs->pieceCount = pieceCount;
  for (size_t i = 0; i < count; i++) {
    const bool isNear = (double)changed[i].squaredGap < CT_NEAR_LEAVES * CT_NEAR_LEAVES;
    pairs->staged[i] = (StagedSum){changed[i].a, changed[i].b, ABSENT, isNear, 0};
  }
  pairs->stagedCount = (int)count;
  pairs->trial++;
  return ctSuccess;
}

ctStatus ctPairsNearChange(Pairs* pairs, double* change, ctCounts* counts) {
  const ctStatus status = stage(pairs, counts);
  if (status == ctSuccess) {
    *change = computeStaged(pairs, true);
  }
  return status;
}

double ctPairsOtherChange(Pairs* pairs) {
  return computeStaged(pairs, false);
}

ctStatus ctPairsAccept(Pairs* pairs) {
  bool isKept = true;
  /* Those that are there first: adding to a row moves them. */
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->kept != ABSENT) {
      pairs->sums.rows[staged->a].sums[staged->kept] = staged->sum;
    }
  }
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->kept == ABSENT) {
      isKept = isKept && ctLeafSumsAdd(&pairs->sums, staged->a, staged->b, staged->sum);
    }
  }
  pairs->stagedCount = 0;
  for (int i = 0; i < pairs->pieceCount; i++) {
    if (pairs->pieces[i].body != 0) {
      const int end = i + 1 < pairs->pieceCount ? pairs->pieces[i + 1].slotBegin : pairs->leafCount * CT_LEAF_WIDTH;
      for (int leaf = pairs->pieces[i].slotBegin / CT_LEAF_WIDTH; leaf * CT_LEAF_WIDTH < end; leaf++) {
        pairs->frameIsStale[leaf] = true;
      }
    }
  }
  return isKept ? ctSuccess : ctOutOfMemory;
}
