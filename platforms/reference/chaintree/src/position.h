/* Positions of particles. The tree must be up to date. */
#ifndef CT_POSITION_H_
#define CT_POSITION_H_

#include "world.h"

/* Computes positions one by one, and keeps frames: neighbours in the sequence share them. */
typedef struct PositionReader {
  const Sequence* sequence;
  World* world;
  int leaf; /* whose frame is kept */
  Frame leafFrame;
  int link; /* whose frame in its leaf is kept */
  Frame linkInLeaf;
  int branch; /* CT_NULL: the world itself; links [branchBegin, branchEnd) */
  int branchBegin;
  int branchEnd;
  double shift[3]; /* of the branch from where callers have it */
} PositionReader;

PositionReader ctPositionReader(const Sequence* sequence, World* world);

/* The position of a particle. In a branch that no joint has displaced it has the reference bits. */
void ctReadPosition(PositionReader* reader, int particle, double position[3]);

/* The same from the sequence's worldOrigin. */
void ctReadFromOrigin(PositionReader* reader, int particle, double position[3]);

/* All particles: 3 * particleCount coordinates. */
void ctReadPositions(const Sequence* sequence, World* world, double* positions);

/* What filled the caller's array. */
typedef struct Copied {
  Revision builtFrom;
  bool* isDisplaced; /* per branch: a joint had displaced it, so that its particles did not have reference bits */
} Copied;

/* Starts with an array that has not been filled. False if there is no memory. */
bool ctCopiedBuild(Copied* copied, Arena* arena, const Sequence* sequence);

/* The same as ctReadPositions, but writes only coordinates that may have changed since the last call. */
void ctRefreshPositions(Copied* copied, const Sequence* sequence, World* world, double* positions);

#endif /* CT_POSITION_H_ */
