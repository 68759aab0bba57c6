/* hardcase.h: a scene in the oracle, and in the engine once for each instruction set and each way of testing trials.
 *
 * Every query is asked of all. The engines must agree with each other in every bit; with the oracle in each clash test
 * and listed pair that is farther than CT_SIGMA from its limit, and in numbers up to rounding. A difference ends the
 * program with a line that names the case.
 */
#ifndef HARDCASE_H_
#define HARDCASE_H_

#include "oracle/oracle.h"
#include "oracle/randomScene.h"
#include "sceneBuilder.h"

#include <stdbool.h>

enum { MOST_ENGINES = 12 };

typedef struct HardCase {
    const char* name;
    Scene* scene; /* the caller's */
    int engineCount;
    ctChainTree* engines[MOST_ENGINES];
    oracleScene* oracle;
    double positionError; /* nm: bound on the rounding error of a coordinate */
    double distanceError; /* nm: the same for a distance */
    double* state;        /* the bits of ctGetState */
    double *positions, *others;
    long clashing, clashFree, doubtful; /* counts of test results */
} HardCase;

/* `name` is for messages. Compares the whole state; acceptTrial and dropTrial compare the parts that are cheap. */
void openCase(HardCase* hard, const char* name, Scene* scene);
void closeCase(HardCase* hard);

/* Opens a trial and returns whether it clashes. */
bool tryChanges(HardCase* hard, int count, const ctChange* changes);
bool tryTurn(HardCase* hard, int link, double angle);
bool tryShift(HardCase* hard, int link, double x, double y, double z);

/* Pairs within the cutoff before or in the open trial. */
void compareChangedPairs(HardCase* hard, double cutoff);

void acceptTrial(HardCase* hard);

/* No bit of the state may have changed. */
void dropTrial(HardCase* hard);

/* Positions, clashes, pairs within the cutoff, least distances, energy and forces, ctValidate. */
void compareState(HardCase* hard, double cutoff);

/* Gives all pairs that clash now a limit of their own, in the engines and then in the oracle. */
void raiseLimits(HardCase* hard);

/* Trials of random links: turns by large, small and odd angles, and small shifts of links that move freely. Trials
 * without a clash are accepted, and a few of the others; the state is compared a few times. */
void wander(HardCase* hard, randomSource* random, int trials, double step, double cutoff);

/* A point of a cube. Numbers are drawn one after another; as arguments of a call they would be in any order. */
void randomPoint(randomSource* random, double low, double high, double point[3]);

/* Ends the program if a condition does not hold. */
void need(bool condition, const HardCase* hard, const char* format, ...) __attribute__((format(printf, 3, 4)));

#endif /* HARDCASE_H_ */
