#include "leaves.h"

#include <stdlib.h>

#include "scene.h"
#include "wide.h"

_Static_assert(CT_LEAF_WIDTH == TREE_WIDTH, "clients see the tree's leaves");

/* ---- Memory ---- */

/* Finds which members have particles, from the leaves up. */
static void findOccupied(Leaves* leaves, const Tree* tree, const Sequence* s) {
  for (int slot = 0; slot < tree->slotCount; slot++) {
    if (s->slotParticle[slot] != CT_NULL) {
      leaves->occupied[coveringNode(slot)] |= (uint16_t)(1u << memberIndex(slot));
    }
  }
  for (int level = 0; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      const int node = tree->levelBegin[level] + i;
      if (leaves->occupied[node] != 0) {
        leaves->occupied[treeParent(tree, level, node)] |= (uint16_t)(1u << memberIndex(i));
      }
    }
  }
}

bool ctLeavesReserve(Leaves* leaves, const Tree* tree, const Sequence* sequence) {
  if (leaves->state != NULL) {
    return true;
  }
  leaves->state = ctArenaAllocate(&leaves->arena, (size_t)tree->levelSize[0], sizeof(ctLeafPositions));
  leaves->occupied = ctArenaAllocate(&leaves->arena, (size_t)tree->nodeCount + 1, sizeof(uint16_t));
  if (leaves->arena.failed) {
    ctArenaFree(&leaves->arena);
    leaves->state = NULL;
    return false;
  }
  findOccupied(leaves, tree, sequence);
  leaves->builtFrom = NO_REVISION;
  return true;
}

bool ctLeavesReservePairs(Leaves* leaves, const Tree* tree) {
  if (leaves->boxes != NULL) {
    return true;
  }
  const size_t inner = (size_t)(tree->nodeCount - tree->levelBegin[1]) + 1;
  leaves->boxes = ctArenaAllocate(&leaves->pairArena, inner, sizeof(AxisBoxes));
  leaves->members = ctArenaAllocate(&leaves->pairArena, inner, sizeof(TrialMembers));
  leaves->trial = ctArenaAllocate(&leaves->pairArena, (size_t)tree->levelSize[0], sizeof(ctLeafPositions));
  leaves->differs = ctArenaAllocate(&leaves->pairArena, inner, sizeof(uint16_t));
  if (leaves->pairArena.failed) {
    ctArenaFree(&leaves->pairArena);
    leaves->boxes = NULL;
    return false;
  }
  for (size_t i = 0; i < inner; i++) {
    clearAxisBoxes(&leaves->boxes[i]);
    clearAxisBoxes(&leaves->members[i].boxes);
  }
  leaves->builtFrom = NO_REVISION; /* boxes are made together with positions */
  return true;
}

void ctLeavesFree(Leaves* leaves) {
  ctArenaFree(&leaves->arena);
  ctArenaFree(&leaves->pairArena);
  free(leaves->changed.pairs);
  free(leaves->all.pairs);
}

bool ctLeafPairsReserve(LeafPairs* pairs, size_t count) {
  if (count <= pairs->capacity) {
    return true;
  }
  const size_t grown = count > 2 * pairs->capacity ? count : 2 * pairs->capacity;
  ctLeafPair* moved = grown > SIZE_MAX / sizeof *moved ? NULL : realloc(pairs->pairs, grown * sizeof *moved);
  if (moved == NULL) {
    return false;
  }
  pairs->pairs = moved;
  pairs->capacity = grown;
  return true;
}

void ctLeavesUpdate(Leaves* leaves, World* world, const Sequence* sequence) {
  const Changes* changes = &world->tree->changes;
  if (leaves->builtFrom == NO_REVISION) {
    leaves->positionError = 0; /* all of them are made again */
  }
  if (stateChangedSince(changes, leaves->builtFrom)) {
    const LeafUpdate update = {leaves, world, sequence, firstMovedSince(changes, leaves->builtFrom), 0, NULL};
    world->tree->wide->updateLeaves(&update);
    leaves->builtFrom = changes->now;
  }
}

void ctLeavesForget(Leaves* leaves) {
  leaves->builtFrom = NO_REVISION;
}

bool ctLeavesAreOf(const Leaves* leaves, const Tree* tree) {
  return leaves->state != NULL && !stateChangedSince(&tree->changes, leaves->builtFrom);
}

void ctLeavesFollow(Leaves* leaves, World* world, const Sequence* sequence, const Trial* trial) {
  const Tree* tree = world->tree;
  if (trial->distanceError > 0) {
    leaves->positionError += trial->distanceError;
  } else {
    const double reach = cornerOf(leafBoxes(leaves, tree, treeSuperRoot(tree)));
    leaves->positionError = larger(leaves->positionError, ctTrialRounding(trial, reach, tree->levelCount));
  }
  if (leaves->positionError > MOST_ERROR) {
    ctLeavesForget(leaves);
    return;
  }
  const LeafUpdate update = {leaves, world, sequence, 0, trial->pieceCount, trial->pieces};
  tree->wide->updateLeaves(&update);
  leaves->builtFrom = tree->changes.now;
}

/* ---- Public calls ---- */

int ctGetLeafCount(const ctChainTree* tree) {
  return tree != NULL ? tree->ownTree.levelSize[0] : 0;
}

void ctGetLeafParticles(const ctChainTree* tree, int* particles) {
  if (tree == NULL || particles == NULL) {
    return;
  }
  const Sequence* s = &tree->sequence;
  const int slots = ctGetLeafCount(tree) * CT_LEAF_WIDTH;
  for (int slot = 0; slot < slots; slot++) {
    particles[slot] = slot < s->slotCount ? s->slotParticle[slot] : CT_NULL;
  }
}

const ctLeafPositions* ctGetLeaves(ctChainTree* tree) {
  if (tree == NULL) {
    return NULL;
  }
  if (!ctLeavesReserve(&tree->leaves, &tree->ownTree, &tree->sequence)) {
    ctFailOutOfMemory(tree);
    return NULL;
  }
  ctLeavesUpdate(&tree->leaves, ctSceneWorld(tree), &tree->sequence);
  return tree->leaves.state;
}

void ctGetMoleculeShift(const ctChainTree* tree, int link, bool inTrial, double shift[3]) {
  if (shift == NULL) {
    return;
  }
  shift[0] = shift[1] = shift[2] = 0;
  if (tree == NULL || link < 0 || link >= tree->sequence.userLinkCount || !tree->sequence.box.isPeriodic) {
    return;
  }
  const Sequence* s = &tree->sequence;
  const Trial* trial = tree->trial;
  const int branch = sequenceBranch(s, sequenceLink(s, link));
  for (int i = 0; i < trial->count && trial->open && inTrial; i++) {
    const int changed = trial->changes[i].link;
    if (isWrapped(s, changed) && sequenceBranch(s, changed) == branch) {
      ctImageShift(&s->box, trial->changes[i].after.wrap, shift);
      return;
    }
  }
  ctSequenceShift(s, branch, shift);
}

int ctGetTrialPieces(ctChainTree* tree, const ctPiece** pieces, const ctTransform** motions) {
  if (tree == NULL || pieces == NULL || motions == NULL) {
    return 0;
  }
  Trial* trial = tree->trial;
  *pieces = NULL;
  *motions = NULL;
  if (!trial->open) {
    return 0;
  }
  ctTrialShow(trial, &tree->sequence);
  *pieces = trial->pieces;
  *motions = trial->worldMotions;
  return trial->pieceCount;
}

int ctGetTrialLinks(ctChainTree* tree, const int** links) {
  if (tree == NULL || links == NULL) {
    return 0;
  }
  Trial* trial = tree->trial;
  *links = NULL;
  if (!trial->open) {
    return 0;
  }
  ctTrialShow(trial, &tree->sequence);
  *links = trial->userLinks;
  return trial->count;
}

ctStatus ctLeavesBegin(ctChainTree* scene, bool inTrial, double cutoff, LeafTask* task) {
  Leaves* leaves = &scene->leaves;
  const Tree* tree = ctSceneTree(scene);
  if (!ctLeavesReserve(leaves, tree, &scene->sequence) || !ctLeavesReservePairs(leaves, tree)) {
    return ctFailOutOfMemory(scene);
  }
  ctLeavesUpdate(leaves, &scene->world, &scene->sequence);
  *task = (LeafTask){
      .leaves = leaves, .tree = tree, .sequence = &scene->sequence, .exclusions = &scene->exclusions, .cutoff = cutoff};
  if (inTrial) {
    ctTrialShow(scene->trial, &scene->sequence);
    task->pieceCount = scene->trial->pieceCount;
    task->pieces = scene->trial->pieces;
    task->motions = scene->trial->motions;
    task->worldMotions = scene->trial->worldMotions;
  }
  return ctSuccess;
}

/* Lists pairs of leaves of the state, or of the open trial. */
static ctStatus listPairs(ctChainTree* scene, bool inTrial, double cutoff, LeafPairs* pairs, ctCounts* counts) {
  if (!(cutoff > 0)) {
    return ctFail(scene, ctInvalidArgument, "the cutoff is %g nm; it must be positive", cutoff);
  }
  ctStatus status = scene->sequence.box.isPeriodic ? ctCheckCutoff(scene, cutoff) : ctSuccess;
  if (status != ctSuccess) {
    return status;
  }
  LeafTask task;
  status = ctLeavesBegin(scene, inTrial, cutoff, &task);
  if (status != ctSuccess) {
    return status;
  }
  task.pairs = pairs;
  pairs->count = 0;
  scene->ownTree.wide->listLeafPairs(&task);
  if (task.failed) {
    return ctFailOutOfMemory(scene);
  }
  if (task.isTooLong) {
    return ctFail(scene, ctInvalidArgument, "a molecule reaches over more than %d periodic boxes", CT_MOST_IMAGE);
  }
  addTests(counts, task.tests, 0);
  return ctSuccess;
}

ctStatus ctGetChangedLeafPairs(ctChainTree* tree, double cutoff, size_t* count, const ctLeafPair** pairs,
                               const ctLeafPositions** positions, ctCounts* counts) {
  CT_REQUIRE(tree, count);
  CT_REQUIRE(tree, pairs);
  CT_REQUIRE(tree, positions);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  const ctStatus status = listPairs(tree, true, cutoff, &tree->leaves.changed, counts);
  if (status == ctSuccess) {
    *count = tree->leaves.changed.count;
    *pairs = tree->leaves.changed.pairs;
    *positions = tree->leaves.trial;
  }
  return status;
}

ctStatus ctGetLeafPairs(ctChainTree* tree, double cutoff, size_t* count, const ctLeafPair** pairs, ctCounts* counts) {
  CT_REQUIRE(tree, count);
  CT_REQUIRE(tree, pairs);
  const ctStatus status = listPairs(tree, false, cutoff, &tree->leaves.all, counts);
  if (status == ctSuccess) {
    *count = tree->leaves.all.count;
    *pairs = tree->leaves.all.pairs;
  }
  return status;
}
