/* What the driver prints: lines of JSON. */
#ifndef ROWS_H_
#define ROWS_H_

#include "driftrace.h"
#include "energyrace.h"
#include "measure.h"
#include "options.h"
#include "touchrace.h"

/* What all rows of results begin with. */
void rowBegin(const char* measure, const Options* options, const Scene* scene, int trials);

void rowTimes(const char* contestant, const char* instructionSet, const Quartiles* microseconds);

void rowCounts(double volumeTests, double particleTests, double updates);

/* The end of rows about exactness. */
void rowDrift(const DriftResult* result);
void rowTouch(const TouchResult* result);

/* The end of a row about energies. */
void rowEnergy(const EnergyResult* result);

/* A row about the build: compiler, flags, instruction set. */
void rowOfBuild(const InstructionSet* set);

/* A row for each contestant there is. */
void rowsOfContestants(const InstructionSet* set);

#endif /* ROWS_H_ */
