/* Positions of particles in the world, read off the tree. */
#ifndef CT_POSITION_H_
#define CT_POSITION_H_

#include "tree.h"

/* Reads particles one after another; neighbours in the sequence share the work of finding a frame. */
typedef struct PositionReader {
  const Sequence* sequence;
  const Tree* tree;
  int leaf; /* whose frame is held */
  Frame leafFrame;
  int link; /* whose frame in its leaf is held */
  Frame linkInLeaf;
  int branch; /* CT_NULL: the world itself; links [branchBegin, branchEnd) */
  int branchBegin;
  int branchEnd;
} PositionReader;

PositionReader ctPositionReader(const Sequence* sequence, const Tree* tree);

/* Particles of a branch that no joint has displaced keep their reference bits. */
void ctReadPosition(PositionReader* reader, int particle, double position[3]);

/* The same from the sequence's worldOrigin. */
void ctReadFromOrigin(PositionReader* reader, int particle, double position[3]);

/* All particles: 3 * particleCount coordinates. */
void ctReadPositions(const Sequence* sequence, const Tree* tree, double* positions);

/* Of which state the coordinates in an array are that somebody keeps. */
typedef struct Copied {
  int64_t time;      /* of the tree; NEVER: of none */
  bool* isDisplaced; /* per branch: whether it was, so that its particles had not their reference bits */
} Copied;

/* Of none. False if there is no memory. */
bool ctCopiedBuild(Copied* copied, Arena* arena, const Sequence* sequence);

/* The same as ctReadPositions, but only writes coordinates that may have changed since. */
void ctRefreshPositions(Copied* copied, const Sequence* sequence, const Tree* tree, double* positions);

#endif /* CT_POSITION_H_ */
