/* The steps of a tape. */
#ifndef CT_TAPESTEPS_H_
#define CT_TAPESTEPS_H_

#include "set.h"

/* Runs all steps on the batch; squares of distances are there. */
void CT_WIDE(runSteps)(const Tape* tape);

#endif /* CT_TAPESTEPS_H_ */
