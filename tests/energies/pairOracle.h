/* pairOracle.h: Lennard-Jones and Coulomb of all pairs of particles, from formulas, in long double. It shares nothing
 * with the library that it judges but the description. */
#ifndef PAIR_ORACLE_H_
#define PAIR_ORACLE_H_

#include "ctenergy.h"

/* An energy, and by how much single precision may miss it. */
typedef struct PairSum {
    long double energy;
    long double doubt;
} PairSum;

/* The energy of all pairs that are not excluded, at these positions (3 * particleCount). */
PairSum sumAllPairs(const ctNonbonded* nonbonded, int particleCount, const double* positions);

#endif /* PAIR_ORACLE_H_ */
