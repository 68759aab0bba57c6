/* loopmember.h: one loop of a population as it grows: which pieces have places, and whether they clash. */
#ifndef CT_LOOPMEMBER_H_
#define CT_LOOPMEMBER_H_

#include "loopshape.h"
#include "turning.h"

typedef struct LoopMember {
  double* turns;        /* of each joint, from its angle as given; 0 before it is drawn */
  double (*places)[3];  /* of each particle */
  double (*middles)[3]; /* of the sphere around each piece */
  bool* isPlaced;       /* each piece */
  Turning head;         /* the motion of the last piece that has grown from either end */
  Turning tail;
  double guide; /* the preference that its weight does not have yet */
  double weight;
} LoopMember;

/* False if there is no memory; the member has to be freed either way. */
bool makeLoopMember(const LoopShape* shape, LoopMember* member);

void freeLoopMember(LoopMember* member);

/* Makes a member one that has no piece. */
void resetLoopMember(const LoopShape* shape, LoopMember* member);

void copyLoopMember(const LoopShape* shape, const LoopMember* from, LoopMember* to);

/* Copies a piece, with the turn of its joint if it is of a side chain. */
void copyPiece(const LoopShape* shape, const LoopMember* from, LoopMember* to, int piece);

/* Moves a piece from where it was given, and has it count as placed. False, with the piece not placed, if it clashes
 * with anything fixed or placed. */
bool placePiece(const LoopShape* shape, LoopMember* member, int piece, const Turning* motion);

#endif /* CT_LOOPMEMBER_H_ */
