#include "standInOracle.h"

#include "../../platforms/reference/energy/tests/bornoracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long double coordinateRounding = 1.5e-7L; /* nm, of distances up to 1 nm */
static const long double energyRounding = 2e-6L;       /* of the terms of a pair */
static const long double pairStep = 1.0L / (1 << 16);  /* kJ/mol, to which a pair's energy is rounded at worst */

enum { COEFFICIENTS = 4, NODES = 64 };

/* What a pair's Coulomb and Born energy is at the cutoff, per product of charges: a cubic in ln(B_i B_j), by least
 * squares over the nodes of Chebyshev from -4.6 to 0.8. */
typedef struct Shift {
    long double c[COEFFICIENTS];
} Shift;

static Shift fitShift(const ctEnergyDefinition* d)
{
    /* By Gram and Schmidt, another way than the library's. */
    static long double basis[COEFFICIENTS][NODES];
    long double nodes[NODES], values[NODES];
    long double powers[COEFFICIENTS][COEFFICIENTS] = {{0}};
    const long double cutoff = d->standIn->pairCutoff;
    for (int n = 0; n < NODES; n++) {
        nodes[n] = -4.6L + 2.7L * (cosl(3.14159265358979323846L * (n + 0.5L) / NODES) + 1);
        const long double product = expl(nodes[n]);
        const long double f = sqrtl(cutoff * cutoff + product * expl(-cutoff * cutoff / (4 * product)));
        values[n] = 1 / cutoff + oracleContrast(d->born, f) / d->born->coulomb / f;
    }
    Shift shift = {{0}};
    for (int i = 0; i < COEFFICIENTS; i++) {
        powers[i][i] = 1;
        for (int n = 0; n < NODES; n++)
            basis[i][n] = powl(nodes[n], i);
        for (int pass = 0; pass < 2; pass++)
            for (int j = 0; j < i; j++) {
                long double product = 0, square = 0;
                for (int n = 0; n < NODES; n++) {
                    product += basis[i][n] * basis[j][n];
                    square += basis[j][n] * basis[j][n];
                }
                for (int n = 0; n < NODES; n++)
                    basis[i][n] -= product / square * basis[j][n];
                for (int k = 0; k < COEFFICIENTS; k++)
                    powers[i][k] -= product / square * powers[j][k];
            }
        long double product = 0, square = 0;
        for (int n = 0; n < NODES; n++) {
            product += basis[i][n] * values[n];
            square += basis[i][n] * basis[i][n];
        }
        for (int k = 0; k < COEFFICIENTS; k++)
            shift.c[k] += product / square * powers[i][k];
    }
    return shift;
}

typedef struct Pair {
    long double energy, slope, size;
} Pair;

static bool isExcluded(const ctNonbonded* d, int i, int j)
{
    for (int n = 0; n < d->exclusionCount; n++) {
        const int* pair = d->exclusions[n];
        if ((pair[0] == i && pair[1] == j) || (pair[0] == j && pair[1] == i))
            return true;
    }
    return false;
}

/* The energy of a pair at these ln B. */
static long double energyOfPair(const ctEnergyDefinition* d, const Shift* shift, int i, int j, long double r,
                                long double logI, long double logJ, bool excluded)
{
    const ctBorn* born = d->born;
    const long double product = expl(logI + logJ);
    const long double f = sqrtl(r * r + product * expl(-r * r / (4 * product)));
    long double energy = oracleContrast(born, f) * born->charges[i] * born->charges[j] / f;
    if (excluded)
        return energy;
    const ctNonbonded* n = d->nonbonded;
    const long double sigma = ((long double)n->sigmas[i] + n->sigmas[j]) / 2;
    const long double sixth = powl(sigma / r, 6);
    const long double log = logI + logJ;
    const long double atCutoff = shift->c[0] + log * (shift->c[1] + log * (shift->c[2] + log * shift->c[3]));
    energy += 4 * sqrtl((long double)n->epsilons[i] * n->epsilons[j]) * sixth * (sixth - 1);
    energy += (long double)CT_COULOMB * n->charges[i] * n->charges[j] / r;
    return energy - born->coulomb * born->charges[i] * born->charges[j] * atCutoff;
}

static long double slopeOfPair(const ctEnergyDefinition* d, const Shift* shift, int i, int j, long double r,
                               long double logI, long double logJ, bool excluded)
{
    const long double h = 1e-5L;
    return (energyOfPair(d, shift, i, j, r, logI + h, logJ, excluded) -
            energyOfPair(d, shift, i, j, r, logI - h, logJ, excluded)) /
           (2 * h);
}

StandInSum sumStandIn(const ctEnergyDefinition* d, int particleCount, const double* positions, const double* far)
{
    StandInSum sum = {0};
    const Shift shift = fitShift(d);
    const long double width = d->standIn->gridWidth;
    long double* logs = malloc(2 * (size_t)particleCount * sizeof *logs);
    long double* beyond = logs + particleCount;
    if (logs == NULL)
        abort();
    for (int i = 0; i < particleCount; i++) {
        const long double born = far[i] + oracleBornSum(d->born, particleCount, positions, i, d->standIn->bornCutoff);
        const long double radius = oracleBornRadius(d->born, i, born);
        const long double log = logl(radius);
        logs[i] = width * rintl(log / width);
        beyond[i] = log - logs[i];
        sum.isAmbiguous |= fabsl(fabsl(beyond[i]) - width / 2) < 2e-5L || !(radius > 0 && radius < 1.4L);
        sum.energy += oracleBornSelf(d->born, i, radius);
        sum.doubt += 1e-5L * fabsl(oracleBornSelf(d->born, i, radius));
    }
    for (int i = 0; i < particleCount; i++)
        for (int j = 0; j < i; j++) {
            const long double r = oracleDistance(positions, i, j);
            const long double cutoff = d->standIn->pairCutoff;
            const bool excluded = isExcluded(d->nonbonded, i, j);
            if (r >= cutoff + coordinateRounding)
                continue;
            const long double energy = energyOfPair(d, &shift, i, j, r, logs[i], logs[j], excluded);
            const long double next = energyOfPair(d, &shift, i, j, r + coordinateRounding, logs[i], logs[j], excluded);
            sum.doubt += 2 * fabsl(next - energy) + energyRounding * fabsl(energy) + pairStep;
            sum.doubt += energyRounding * 1000 * fabsl((long double)d->born->charges[i] * d->born->charges[j]) / r;
            sum.isAmbiguous |= fabsl(r - cutoff) < coordinateRounding || r < 0.002L || energy > 1e5L;
            if (r >= cutoff)
                continue;
            sum.energy += energy;
            sum.energy += beyond[i] * slopeOfPair(d, &shift, i, j, r, logs[i], logs[j], excluded);
            sum.energy += beyond[j] * slopeOfPair(d, &shift, j, i, r, logs[j], logs[i], excluded);
            sum.doubt += (fabsl(beyond[i]) + fabsl(beyond[j])) / 1000;
        }
    free(logs);
    return sum;
}
