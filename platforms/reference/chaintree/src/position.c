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

static bool isDisplaced(const Sequence* s, int particle) {
  return s->displaced[s->branch[s->particleLink[particle]]] != 0;
}

static void readFrame(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  const int link = s->particleLink[particle];
  const int slot = s->particleSlot[particle];
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
    sequenceLocal(s, particle, local);
    transformPoint(&reader->linkInLeaf, local, local);
  }
  transformPoint(&reader->leafFrame, local, position);
}

void ctReadPosition(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  if (!isDisplaced(s, particle)) {
    memcpy(position, s->reference + 3 * (size_t)particle, 3 * sizeof(double));
    return;
  }
  readFrame(reader, particle, position);
  for (int k = 0; k < 3; k++) {
    position[k] += s->worldOrigin[k];
  }
}

void ctReadFromOrigin(PositionReader* reader, int particle, double position[3]) {
  const Sequence* s = reader->sequence;
  if (isDisplaced(s, particle)) {
    readFrame(reader, particle, position);
  } else {
    subtract(s->reference + 3 * (size_t)particle, s->worldOrigin, position);
  }
}

void ctReadPositions(const Sequence* s, const Tree* tree, double* positions) {
  PositionReader reader = ctPositionReader(s, tree);
  for (int link = 0; link < s->linkCount; link++) {
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      const int particle = s->slotParticle[slot];
      if (particle != CT_NULL) {
        ctReadPosition(&reader, particle, positions + 3 * (size_t)particle);
      }
    }
    for (int i = s->idleBegin[link]; i < s->idleBegin[link + 1]; i++) {
      ctReadPosition(&reader, s->idleParticle[i], positions + 3 * (size_t)s->idleParticle[i]);
    }
  }
}
