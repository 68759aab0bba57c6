/* standInOracle.h: the energy U1 that ctStandIn describes, of all pairs of particles, in long double. It shares nothing
 * with the library that it judges but the descriptions. */
#ifndef STANDIN_ORACLE_H_
#define STANDIN_ORACLE_H_

#include "ctenergy.h"

typedef struct StandInSum {
    long double energy;
    long double doubt; /* bound on its error in single precision */
    bool isAmbiguous;  /* rounding may decide where a radius is on the grid or a pair at the cutoff, or some pair or
                          radius is beyond what the stand-in bounds */
} StandInSum;

/* Lets the distances of both sums be those of nearest images in a periodic box of these vectors; NULL: in none. */
void setStandInBox(const double (*box)[3]);

/* The energies that the stand-in stands for, and the sum of the magnitudes of its parts, larger for near pairs, whose
 * distances round more. */
typedef struct WholeSum {
    long double nonbonded, born, size;
} WholeSum;

/* Both cutoffs are finite. */
WholeSum sumWhole(const ctEnergyDefinition* d, int particleCount, const double* positions);

/* `far` is the part of each Born sum that stands for particles far away. */
StandInSum sumStandIn(const ctEnergyDefinition* d, int particleCount, const double* positions, const double* far);

/* Largest error of the library's pair energy at the cutoff, per product of charges and in units of Coulomb's constant,
 * and of a fifth of its derivative, for radii from 0.1 to 0.7 nm. */
long double findWorstShift(const ctEnergyDefinition* d);

#endif /* STANDIN_ORACLE_H_ */
