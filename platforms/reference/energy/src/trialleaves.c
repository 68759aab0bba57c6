#include "trialleaves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "trialview.h"

bool ctReserveEntries(void** array, int* capacity, size_t count, size_t size) {
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

/* ---- Life ---- */

bool ctTrialLeavesCreate(TrialLeaves* leaves, ctChainTree* tree, double cutoff, int particleCount, const int* slotOf) {
  const int leafCount = ctGetLeafCount(tree);
  const size_t size = (size_t)leafCount + 1;
  *leaves = (TrialLeaves){.tree = tree, .cutoff = cutoff, .leafCount = leafCount};
  leaves->wide = ctFindWide(ctGetInstructionSet(tree));
  leaves->occupied = calloc(size, sizeof *leaves->occupied);
  leaves->frames = allocateLines(size, sizeof *leaves->frames);
  leaves->frameIsOutdated = calloc(size, sizeof *leaves->frameIsOutdated);
  leaves->trialFrames = allocateLines(size, sizeof *leaves->trialFrames);
  leaves->frameTrial = calloc(size, sizeof *leaves->frameTrial);
  leaves->frameInTrial = calloc(size, sizeof *leaves->frameInTrial);
  leaves->movers = calloc(size, sizeof *leaves->movers);
  if (leaves->occupied == NULL || leaves->frames == NULL || leaves->frameIsOutdated == NULL ||
      leaves->trialFrames == NULL || leaves->frameTrial == NULL || leaves->frameInTrial == NULL ||
      leaves->movers == NULL) {
    ctTrialLeavesFree(leaves);
    return false;
  }
  for (int i = 0; i < particleCount; i++) {
    if (slotOf[i] != CT_NULL) {
      leaves->occupied[slotOf[i] / CT_LEAF_WIDTH] |= 1u << slotOf[i] % CT_LEAF_WIDTH;
    }
  }
  return true;
}

void ctTrialLeavesFree(TrialLeaves* leaves) {
  free(leaves->occupied);
  freeLines(leaves->frames);
  free(leaves->frameIsOutdated);
  freeLines(leaves->trialFrames);
  free(leaves->frameTrial);
  free(leaves->frameInTrial);
  free(leaves->movers);
  free(leaves->changed);
  free(leaves->pieces);
  *leaves = (TrialLeaves){0};
}

/* ---- The state ---- */

void ctTrialLeavesOutdate(TrialLeaves* leaves) {
  leaves->changedCount = 0;
  leaves->nearCount = 0;
  leaves->pieceCount = 0;
  for (int leaf = 0; leaf < leaves->leafCount; leaf++) {
    leaves->frameIsOutdated[leaf] = true;
  }
  leaves->statePositions = ctGetLeaves(leaves->tree);
  leaves->isPeriodic = ctGetBox(leaves->tree, leaves->box);
}

ctStatus ctTrialLeavesRefresh(TrialLeaves* leaves, size_t* count, const ctLeafPair** pairs, ctCounts* counts) {
  ctTrialLeavesOutdate(leaves);
  return leaves->statePositions != NULL ? ctGetLeafPairs(leaves->tree, leaves->cutoff, count, pairs, counts)
                                        : ctOutOfMemory;
}

const LeafFrame* ctStateFrame(TrialLeaves* leaves, int leaf) {
  if (leaves->frameIsOutdated[leaf]) {
    leaves->frameIsOutdated[leaf] = false;
    leaves->wide->makeFrame(&leaves->statePositions[leaf], leaves->occupied[leaf], &leaves->frames[leaf]);
  }
  return &leaves->frames[leaf];
}

/* ---- Trials ---- */

static int isNear(const ctLeafPair* pair) {
  return (double)pair->squaredGap < CT_NEAR_LEAVES * CT_NEAR_LEAVES ? 1 : 0;
}

/* Lists near pairs, then the others, without branches, which would be mispredicted. */
static void listChanged(TrialLeaves* leaves, int count, const ctLeafPair* changed) {
  leaves->changedCount = count;
  leaves->nearCount = 0;
  for (int i = 0; i < count; i++) {
    leaves->nearCount += isNear(&changed[i]);
  }
  int next[2] = {leaves->nearCount, 0};
  for (int i = 0; i < count; i++) {
    leaves->changed[next[isNear(&changed[i])]++] = changed[i];
  }
}

/* The greatest displacement of a piece, nm. */
static double findFarthest(int count, const ctPiece* pieces, const ctTransform* motions) {
  double squared = 0;
  for (int i = 0; i < count; i++) {
    const double* shift = motions[pieces[i].body].translation;
    squared = fmax(squared, shift[0] * shift[0] + shift[1] * shift[1] + shift[2] * shift[2]);
  }
  return sqrt(squared);
}

ctStatus ctTrialLeavesOpen(TrialLeaves* leaves, ctCounts* counts) {
  size_t count;
  const ctLeafPair* changed;
  const ctPiece* pieces;
  const ctTransform* motions;
  const int* particles;
  leaves->changedCount = 0;
  leaves->nearCount = 0;
  leaves->statePositions = ctGetLeaves(leaves->tree);
  const ctStatus status =
      ctGetChangedLeafPairs(leaves->tree, leaves->cutoff, &count, &changed, &leaves->trialPositions, counts);
  if (leaves->statePositions == NULL || status != ctSuccess) {
    return status != ctSuccess ? status : ctOutOfMemory;
  }
  const int pieceCount = ctGetTrialPieces(leaves->tree, &pieces, &motions);
  if (!ctReserveEntries((void**)&leaves->changed, &leaves->changedCapacity, count, sizeof *leaves->changed) ||
      !ctReserveEntries((void**)&leaves->pieces, &leaves->pieceCapacity, (size_t)pieceCount, sizeof *leaves->pieces)) {
    return ctOutOfMemory;
  }
  memcpy(leaves->pieces, pieces, (size_t)pieceCount * sizeof *pieces);
  leaves->pieceCount = pieceCount;
  leaves->isDisplacement = ctGetTrialParticles(leaves->tree, &particles) > 0;
  if (leaves->isDisplacement) {
    leaves->farthest = findFarthest(pieceCount, pieces, motions);
  }
  listChanged(leaves, (int)count, changed);
  leaves->trial++;
  return ctSuccess;
}

/* True if some slots of a leaf move in the trial. */
static bool leafMoves(const TrialLeaves* leaves, int leaf) {
  const int begin = leaf * CT_LEAF_WIDTH;
  const ctPiece* piece = findPiece(leaves->pieces, leaves->pieceCount, begin + CT_LEAF_WIDTH - 1);
  while (piece->body == 0 && piece->slotBegin > begin) {
    piece--;
  }
  return piece->body != 0;
}

static int pieceEnd(const TrialLeaves* leaves, int piece) {
  return piece + 1 < leaves->pieceCount ? leaves->pieces[piece + 1].slotBegin : leaves->leafCount * CT_LEAF_WIDTH;
}

/* The particles of a leaf that move in the trial, as bits. */
static uint16_t findMovers(const TrialLeaves* leaves, int leaf) {
  const int first = leaf * CT_LEAF_WIDTH;
  unsigned movers = 0;
  for (int i = 0; i < leaves->pieceCount; i++) {
    const int begin = leaves->pieces[i].slotBegin - first;
    const int end = pieceEnd(leaves, i) - first;
    if (leaves->pieces[i].body != 0 && begin < CT_LEAF_WIDTH && end > 0) {
      movers |= (0xffffu >> (end < CT_LEAF_WIDTH ? CT_LEAF_WIDTH - end : 0)) & ~0u << (begin > 0 ? begin : 0);
    }
  }
  return (uint16_t)(movers & leaves->occupied[leaf]);
}

const LeafFrame* ctTrialFrame(TrialLeaves* leaves, int leaf) {
  if (leaves->frameTrial[leaf] != leaves->trial) {
    leaves->frameTrial[leaf] = leaves->trial;
    if (leafMoves(leaves, leaf)) {
      LeafFrame* frame = &leaves->trialFrames[leaf];
      leaves->wide->makeFrame(&leaves->trialPositions[leaf], leaves->occupied[leaf], frame);
      leaves->frameInTrial[leaf] = frame;
      if (leaves->isDisplacement) {
        leaves->movers[leaf] = findMovers(leaves, leaf);
      }
    } else {
      leaves->frameInTrial[leaf] = ctStateFrame(leaves, leaf);
    }
  }
  return leaves->frameInTrial[leaf];
}

void ctTrialLeavesAccept(TrialLeaves* leaves) {
  for (int i = 0; i < leaves->pieceCount; i++) {
    if (leaves->pieces[i].body != 0) {
      const int end = pieceEnd(leaves, i);
      for (int leaf = leaves->pieces[i].slotBegin / CT_LEAF_WIDTH; leaf * CT_LEAF_WIDTH < end; leaf++) {
        leaves->frameIsOutdated[leaf] = true;
      }
    }
  }
}
