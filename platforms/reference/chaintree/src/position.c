#include "position.h"

#include <string.h>

PositionReader ctPositionReader(const Sequence* sequence, const Tree* tree) {
  PositionReader reader = {0};
  reader.sequence = sequence;
  reader.tree = tree;
  reader.leaf = CT_NULL;
  reader.link = CT_NULL;
  return reader;
}

/* Whether a joint has displaced the branch of the world that a link is in. */
static bool isDisplaced(PositionReader* reader, int link) {
  const Sequence* s = reader->sequence;
  if (link < reader->branchBegin || link >= reader->branchEnd) {
    reader->branch = sequenceBranch(s, link);
    reader->branchBegin = reader->branch == CT_NULL ? 0 : s->branchHead[reader->branch];
    reader->branchEnd = reader->branch == CT_NULL ? 1 : sequenceEnd(s, reader->branchBegin);
  }
  return reader->branch != CT_NULL && s->displaced[reader->branch] != 0;
}

static void readFrame(PositionReader* reader, int link, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int slot = particleSlot(s, particle);
  const int leaf = (slot != CT_NULL ? slot : s->slotBegin[link]) / TREE_WIDTH;
  if (leaf != reader->leaf) {
    reader->leaf = leaf;
    reader->leafFrame = ctTreeFrame(reader->tree, 0, leaf);
  }
  double local[3];
  if (slot != CT_NULL) {
    treeLocal(reader->tree, slot, local);
  } else {
    if (link != reader->link) {
      reader->link = link;
      reader->linkInLeaf = ctTreeLinkInLeaf(s, link);
    }
    sequenceLocal(s, link, particle, local);
    transformPoint(&reader->linkInLeaf, local, local);
  }
  transformPoint(&reader->leafFrame, local, position);
}

void ctReadPosition(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int link = particleLink(s, particle);
  if (!isDisplaced(reader, link)) {
    memcpy(position, s->reference + 3 * (size_t)particle, 3 * sizeof(double));
    return;
  }
  readFrame(reader, link, particle, position);
  for (int k = 0; k < 3; k++) {
    position[k] += s->worldOrigin[k];
  }
}

void ctReadFromOrigin(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int link = particleLink(s, particle);
  if (isDisplaced(reader, link)) {
    readFrame(reader, link, particle, position);
  } else {
    subtract(s->reference + 3 * (size_t)particle, s->worldOrigin, position);
  }
}

void ctReadPositions(const Sequence* s, const Tree* tree, double* positions) {
  PositionReader reader = ctPositionReader(s, tree);
  int idle = 0;
  for (int link = 0; link < s->linkCount; link++) {
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      const int particle = s->slotParticle[slot];
      if (particle != CT_NULL) {
        ctReadPosition(&reader, particle, positions + 3 * (size_t)particle);
      }
    }
    for (; idle < s->idleCount && particleLink(s, s->idleParticle[idle]) == link; idle++) {
      ctReadPosition(&reader, s->idleParticle[idle], positions + 3 * (size_t)s->idleParticle[idle]);
    }
  }
}
