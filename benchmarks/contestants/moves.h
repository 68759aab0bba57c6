/* The trials of a run. They are made before they are timed, and every contestant gets the same. */
#ifndef MOVES_H_
#define MOVES_H_

#include "contestant.h"
#include "random.h"

typedef enum MoveKind {
  movesUniform,      /* of the backbone; a new angle that is uniform, so that the change, modulo a turn, is so too */
  movesGaussian,     /* of the backbone; the change is Gaussian */
  movesBiased,       /* of the backbone; Gaussian, biased to leave in place what lies behind the last torsion */
  movesSideChain,    /* of side chains; the new angle is uniform */
  movesSideChainStep /* of side chains; the change is Gaussian */
} MoveKind;

typedef struct MoveRule {
  MoveKind kind;
  double angle; /* standard deviation of Gaussian changes, rad */
  int kappa;    /* consecutive torsions that a trial turns */
} MoveRule;

/* Makes trials of `rule.kappa` turns each. */
typedef struct Moves {
  const Scene* scene;
  MoveRule rule;
  int choiceCount;
  int* choices; /* torsions of which kappa in a row are turned */
  Random random;
} Moves;

/* False if there are too few torsions of the kind that the rule calls for; then `error`, of `size` bytes, says so. */
bool movesInit(Moves* moves, const Scene* scene, MoveRule rule, uint64_t seed, char* error, size_t size);
void movesFree(Moves* moves);

/* Whether trials depend on where the particles are. */
static inline bool movesNeedPositions(const Moves* moves) {
  return moves->rule.kind == movesBiased;
}

/* Writes the turns of one trial. `spheres` are the particles before it, and not read unless movesNeedPositions. */
void movesNext(Moves* moves, const Sphere* spheres, Turn* turns);

#endif /* MOVES_H_ */
