/* randomPairSet.h: random pair sets of every kind, each with a formula for its energy in long double.
 */
#ifndef RANDOM_PAIR_SET_H_
#define RANDOM_PAIR_SET_H_

#include "ctenergy.h"
#include "oracle/randomSource.h"
#include "pairOracle.h"

/* `size` is the sum of the absolute values of the energy's parts. */
typedef struct PairValue {
    long double energy;
    long double size;
} PairValue;

typedef struct randomPairSet randomPairSet;

/* The formula of a distance and the parameters of two particles. */
typedef PairValue pairFormula(const randomPairSet* set, long double r, const double* first, const double* second);

enum { MOST_PAIR_OPERATIONS = 60, MOST_PAIR_TABLES = 2, PAIR_PARAMETERS = 4 };

struct randomPairSet {
    ctPairSet set; /* of these arrays */
    pairFormula* formula;
    int operationCount;
    ctOperation operations[MOST_PAIR_OPERATIONS];
    ctTable tables[MOST_PAIR_TABLES];
    double* values[MOST_PAIR_TABLES];
    double* parameters;
    int (*exclusions)[2];
    ctInteractionGroup* groups;
};

void randomPairSetCreate(randomPairSet* set, randomSource* random, int particleCount);
void randomPairSetDestroy(randomPairSet* set);

/* The energy of all pairs of particles that count, at these positions (3 * particleCount). */
PairSum sumPairSet(const randomPairSet* set, int particleCount, const double* positions);

#endif /* RANDOM_PAIR_SET_H_ */
