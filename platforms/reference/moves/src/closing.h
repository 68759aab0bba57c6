/* closing.h: how the two ends of a growing loop are joined. */
#ifndef CT_CLOSING_H_
#define CT_CLOSING_H_

#include "loopsteps.h"
#include "turning.h"

/* Finds all turns of the six pivots that join a loop: `turns` holds the turns of all joints of the path, of which those
 * between the pivots count. head: the motion of the piece before the first closing joint from where it was given; tail:
 * that of the piece behind the last. Returns the number of solutions; 0 also where rounding leaves none. */
int findJoins(const LoopShape* shape, const LoopSteps* steps, const Turning* head, const Turning* tail,
              const double* turns, double solutions[CT_CLOSURES_MOST][CT_PIVOTS]);

/* log |J| of the pivots after these turns of all closing joints. */
double logJacobianOf(const LoopShape* shape, const LoopSteps* steps, const double* turns);

#endif /* CT_CLOSING_H_ */
