#include "position.h"

#include <string.h>

PositionReader ctPositionReader(const Sequence* sequence, World* world) {
  PositionReader reader = {0};
  reader.sequence = sequence;
  reader.world = world;
  reader.leaf = CT_NULL;
  reader.link = CT_NULL;
  return reader;
}

/* True if a joint has displaced the branch of the world that a link is in. */
static inline bool isDisplaced(PositionReader* reader, int link) {
  const Sequence* s = reader->sequence;
  if (link < reader->branchBegin || link >= reader->branchEnd) {
    reader->branch = sequenceBranch(s, link);
    reader->branchBegin = reader->branch == CT_NULL ? 0 : s->branchHead[reader->branch];
    reader->branchEnd = reader->branch == CT_NULL ? 1 : sequenceEnd(s, reader->branchBegin);
    ctSequenceShift(s, reader->branch, reader->shift);
  }
  return reader->branch != CT_NULL && s->displaced[reader->branch] != 0;
}

static void readFrame(PositionReader* reader, int link, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int slot = particleSlot(s, particle);
  const int leaf = coveringNode(slot != CT_NULL ? slot : s->slotBegin[link]);
  if (leaf != reader->leaf) {
    reader->leaf = leaf;
    reader->leafFrame = ctWorldReadFrame(reader->world, leaf);
  }
  double local[3];
  if (slot != CT_NULL) {
    treeLocal(reader->world->tree, slot, local);
  } else {
    if (link != reader->link) {
      reader->link = link;
      reader->linkInLeaf = ctTreeLinkInLeaf(reader->world->tree, s, link);
    }
    sequenceLocal(s, link, particle, local);
    transformPoint(&reader->linkInLeaf, local, local);
  }
  transformPoint(&reader->leafFrame, local, position);
}

static inline void keepReference(const Sequence* s, int particle, double position[3]) {
  memcpy(position, s->reference + 3 * (size_t)particle, 3 * sizeof(double));
}

/* From inside the engine to where callers have a position. */
static inline void addOrigin(const PositionReader* reader, double position[3]) {
  for (int k = 0; k < 3; k++) {
    position[k] = position[k] + reader->sequence->worldOrigin[k] - reader->shift[k];
  }
}

void ctReadPosition(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int link = particleLink(s, particle);
  if (!isDisplaced(reader, link)) {
    keepReference(s, particle, position);
    return;
  }
  readFrame(reader, link, particle, position);
  addOrigin(reader, position);
}

void ctReadFromOrigin(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int link = particleLink(s, particle);
  if (isDisplaced(reader, link)) {
    readFrame(reader, link, particle, position);
  } else {
    subtract(s->reference + 3 * (size_t)particle, s->worldOrigin, position);
    add(position, reader->shift);
  }
}

static void readLeaf(PositionReader* reader, int leaf, const Frame* frame, double* positions) {
  const Sequence* s = reader->sequence;
  const Leaf* local = &reader->world->tree->leaf[leaf];
  double world[3][TREE_WIDTH]; /* the sums of transformPoint and addOrigin, all slots at a time */
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < TREE_WIDTH; i++) {
      world[k][i] = frame->m[k][0] * local->x[i] + frame->m[k][1] * local->y[i] + frame->m[k][2] * local->z[i] +
                    frame->m[k][3] + s->worldOrigin[k];
    }
  }
  int end;
  const int begin = treeSlots(reader->world->tree, 0, leaf, &end);
  for (int slot = begin; slot < end; slot++) {
    const int particle = s->slotParticle[slot];
    if (particle == CT_NULL) {
      continue;
    }
    double* position = positions + 3 * (size_t)particle;
    if (isDisplaced(reader, s->slotLink[slot])) {
      for (int k = 0; k < 3; k++) {
        position[k] = world[k][slot - begin] - reader->shift[k];
      }
    } else {
      keepReference(s, particle, position);
    }
  }
}

/* Reads the particles with slots of leaves [begin, end) that have changed since a revision. */
static void readLeaves(PositionReader* reader, int begin, int end, Revision since, double* positions) {
  const Tree* tree = reader->world->tree;
  const int firstMoved = firstMovedSince(&tree->changes, since);
  for (int leaf = begin; leaf < end; leaf++) {
    if (leaf >= firstMoved || tree->contentRevision[leaf] > since) {
      const Frame frame = ctWorldReadFrame(reader->world, leaf);
      readLeaf(reader, leaf, &frame, positions);
    }
  }
}

/* The same for entries [begin, end) of slotlessParticle. */
static void readSlotless(PositionReader* reader, int begin, int end, Revision since, double* positions) {
  const Sequence* s = reader->sequence;
  const Tree* tree = reader->world->tree;
  const int firstMoved = firstMovedSince(&tree->changes, since);
  for (int i = begin; i < end; i++) {
    const int particle = s->slotlessParticle[i];
    const int leaf = coveringNode(s->slotBegin[particleLink(s, particle)]);
    if (leaf >= firstMoved || tree->contentRevision[leaf] > since) {
      ctReadPosition(reader, particle, positions + 3 * (size_t)particle);
    }
  }
}

static void readSince(const Sequence* s, World* world, Revision since, double* positions) {
  PositionReader reader = ctPositionReader(s, world);
  readLeaves(&reader, 0, world->tree->levelSize[0], since, positions);
  readSlotless(&reader, 0, s->slotlessCount, since, positions);
}

void ctReadPositions(const Sequence* s, World* world, double* positions) {
  readSince(s, world, NO_REVISION, positions);
}

/* ---- Arrays that the caller keeps ---- */

bool ctCopiedBuild(Copied* copied, Arena* arena, const Sequence* s) {
  copied->builtFrom = NO_REVISION;
  copied->isDisplaced = ctArenaAllocate(arena, (size_t)s->branchCount, sizeof(bool));
  return !arena->failed;
}

/* Reads all particles of a branch. */
static void readBranch(const Sequence* s, World* world, int branch, double* positions) {
  const int head = s->branchHead[branch];
  const int end = sequenceEnd(s, head);
  PositionReader reader = ctPositionReader(s, world);
  readLeaves(&reader, coveringNode(s->slotBegin[head]), coveringNode(s->slotBegin[end] - 1) + 1, NO_REVISION,
             positions);
  readSlotless(&reader, sequenceSlotless(s, head), sequenceSlotless(s, end), NO_REVISION, positions);
}

void ctRefreshPositions(Copied* copied, const Sequence* s, World* world, double* positions) {
  readSince(s, world, copied->builtFrom, positions);
  for (int branch = 0; branch < s->branchCount; branch++) {
    const bool isDisplacedNow = s->displaced[branch] != 0;
    if (copied->isDisplaced[branch] != isDisplacedNow) {
      copied->isDisplaced[branch] = isDisplacedNow;
      readBranch(s, world, branch, positions);
    }
  }
  copied->builtFrom = world->tree->changes.now;
}
