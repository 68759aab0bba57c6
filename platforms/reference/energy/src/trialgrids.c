#include "trialgrids.h"

#include <stdlib.h>
#include <string.h>

#include "trialview.h"

/* ---- Life ---- */

static bool findSections(TrialGrids* grids, const ctDefinition* scene) {
  const int leafCount = grids->leaves->leafCount;
  int* particles = malloc(((size_t)leafCount * CT_LEAF_WIDTH + 1) * sizeof *particles);
  if (particles == NULL) {
    return false;
  }
  ctGetLeafParticles(grids->leaves->tree, particles);
  ctFindLeafSections(scene, particles, leafCount, grids->sections);
  free(particles);
  return true;
}

bool ctTrialGridsCreate(TrialGrids* grids, TrialLeaves* leaves, const ctDefinition* scene) {
  const size_t size = (size_t)leaves->leafCount + 1;
  *grids = (TrialGrids){.leaves = leaves, .kernels = ctFindTapeKernels(ctGetInstructionSet(leaves->tree))};
  grids->sections = calloc(size, sizeof *grids->sections);
  grids->state = calloc(size, sizeof *grids->state);
  grids->isStale = calloc(size, sizeof *grids->isStale);
  grids->trial = calloc(size, sizeof *grids->trial);
  grids->inTrial = calloc(size, sizeof *grids->inTrial);
  grids->gridStamp = calloc(size, sizeof *grids->gridStamp);
  grids->motionStamp = calloc(size, sizeof *grids->motionStamp);
  grids->motions = calloc(size, sizeof *grids->motions);
  if (grids->sections == NULL || grids->state == NULL || grids->isStale == NULL || grids->trial == NULL ||
      grids->inTrial == NULL || grids->gridStamp == NULL || grids->motionStamp == NULL || grids->motions == NULL ||
      !findSections(grids, scene)) {
    ctTrialGridsFree(grids);
    return false;
  }
  return true;
}

void ctTrialGridsFree(TrialGrids* grids) {
  free(grids->sections);
  free(grids->state);
  free(grids->isStale);
  free(grids->trial);
  free(grids->inTrial);
  free(grids->gridStamp);
  free(grids->motionStamp);
  free(grids->motions);
  *grids = (TrialGrids){0};
}

/* ---- Grids ---- */

void ctTrialGridsOpen(TrialGrids* grids) {
  const TrialLeaves* leaves = grids->leaves;
  grids->movedBegin = 0;
  grids->movedEnd = leaves->leafCount * CT_LEAF_WIDTH;
  if (leaves->pieceCount > 1 && leaves->pieces[0].body == 0) {
    grids->movedBegin = leaves->pieces[1].slotBegin;
  }
  if (leaves->pieceCount > 0 && leaves->pieces[leaves->pieceCount - 1].body == 0) {
    grids->movedEnd = leaves->pieces[leaves->pieceCount - 1].slotBegin;
  }
}

void ctTrialGridsForget(TrialGrids* grids) {
  memset(grids->isStale, true, (size_t)grids->leaves->leafCount * sizeof *grids->isStale);
}

void ctTrialGridsAccept(TrialGrids* grids) {
  ctMarkMovedLeaves(grids->leaves, grids->isStale);
}

const LeafGrid* ctStateGrid(TrialGrids* grids, int leaf) {
  if (grids->isStale[leaf]) {
    grids->isStale[leaf] = false;
    grids->kernels->makeGrid(&grids->leaves->statePositions[leaf], grids->leaves->occupied[leaf], &grids->state[leaf]);
  }
  return &grids->state[leaf];
}

const LeafGrid* ctMovedGrid(TrialGrids* grids, int leaf) {
  const TrialLeaves* leaves = grids->leaves;
  if (grids->gridStamp[leaf] != leaves->trial) {
    grids->gridStamp[leaf] = leaves->trial;
    if (ctMotionOfMoved(grids, leaf)->body != 0) {
      grids->kernels->makeGrid(&leaves->trialPositions[leaf], leaves->occupied[leaf], &grids->trial[leaf]);
      grids->inTrial[leaf] = &grids->trial[leaf];
    } else {
      grids->inTrial[leaf] = ctStateGrid(grids, leaf);
    }
  }
  return grids->inTrial[leaf];
}

/* ---- Motions ---- */

/* The body of particles of a leaf, given as bits; `piece` is the last one of the leaf. */
static int bodyOf(const ctPiece* piece, int leafBegin, unsigned members) {
  int body = MANY_BODIES;
  bool isFound = false;
  for (; members != 0; piece--) {
    const int begin = piece->slotBegin - leafBegin;
    const unsigned own = begin > 0 ? members & ~0u << begin : members;
    if (own != 0) {
      if (isFound && piece->body != body) {
        return MANY_BODIES;
      }
      body = piece->body;
      isFound = true;
    }
    members &= ~own;
  }
  return body;
}

static void findMotion(const TrialGrids* grids, int leaf, LeafMotion* motion) {
  const TrialLeaves* leaves = grids->leaves;
  const int begin = leaf * CT_LEAF_WIDTH;
  const ctPiece* last = findPiece(leaves->pieces, leaves->pieceCount, begin + CT_LEAF_WIDTH - 1);
  if (last->slotBegin <= begin) {
    motion->body = last->body;
    return;
  }
  motion->body = bodyOf(last, begin, leaves->occupied[leaf]);
  for (int s = 0; motion->body == MANY_BODIES && s < MOST_SECTIONS; s++) {
    motion->sections[s] = bodyOf(last, begin, grids->sections[leaf].members[s]);
  }
}

const LeafMotion* ctMotionOfMoved(TrialGrids* grids, int leaf) {
  LeafMotion* motion = &grids->motions[leaf];
  if (grids->motionStamp[leaf] != grids->leaves->trial) {
    grids->motionStamp[leaf] = grids->leaves->trial;
    findMotion(grids, leaf, motion);
  }
  return motion;
}
