/* operations.h: the operations of random programs. Each changes both engine and oracle, or queries both. */
#ifndef OPERATIONS_H_
#define OPERATIONS_H_

#include "program.h"

/* operations.c: runs operations of random kinds, until there have been `most` or the bytes that choose are used up.
 * Returns how many there have been. */
int runOperations(Program* program, int most);

void printTally(const Tally* tally);

/* trialOperations.c. Operations that need an open trial do nothing without one. */
void propose(Program* program);
void compareVerdicts(Program* program);
void compareChangedPairs(Program* program);
void acceptTrial(Program* program);
void acceptAndCompareLists(Program* program);
void rejectTrial(Program* program);

/* The engine's verdict on the open trial, after comparing it. */
bool testTrial(Program* program);

/* Accepts in the engine alone, so that the oracle still knows the trial. */
void acceptInEngine(Program* program);

/* A change of a movable link. */
ctChange chooseChange(Program* program, int link);

/* displacementOperations.c: trials of particles that are displaced within their links, in flexible scenes. Proposes
 * one in engine and oracle, and returns how many particles it displaces; without a particle that can move, none. */
int proposeDisplacements(Program* program);

/* Opens a trial of displacements in engine and oracle. */
void openDisplacements(Program* program, int count, const int* particles, const double* shifts);

/* Refused displacements. */
void displaceNonsense(Program* program);

/* The trial displaces the particles that it was proposed to, and no link; or no particle. */
void requireTrialParticles(const Program* program);

/* A displacement that a flexible scene takes, if a particle can move. */
ctDisplacement chooseDisplacement(Program* program);

/* Accepts displacements in the engine: all other particles, and all links, keep the bits of their places. */
void acceptDisplacements(Program* program, ctCounts* counts);

/* limitOperations.c */
void setLimits(Program* program);
void raiseLimits(Program* program);
void acceptAndRaiseLimits(Program* program);
void requireSameLimits(const Program* program);

/* stateOperations.c */
void setPositions(Program* program);
void setState(Program* program);
void comparePositions(Program* program);
void compareTorsionAngle(Program* program);
void compareRelativeTransform(Program* program);
void compareCentroid(Program* program);
void validate(Program* program);

/* queryOperations.c */
void compareClashes(Program* program);
void compareNeighborPairs(Program* program);
void compareProbe(Program* program);
void compareMinimumDistance(Program* program);
void compareEnergy(Program* program);
void endListsEarly(Program* program);

/* refusedOperations.c: calls that must fail, and change nothing. */
void callWithoutTrial(Program* program);
void proposeNonsense(Program* program);
void queryNonsense(Program* program);
void setNonsense(Program* program);

/* definitionOperations.c: scenes that must be refused; and scenes of the largest and smallest numbers, which must not.
 */
void createNonsense(Program* program);
void goToExtremes(Program* program);

#endif /* OPERATIONS_H_ */
