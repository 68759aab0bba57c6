#include "standInOracle.h"

#include "../../platforms/reference/energy/src/standinpair.h"
#include "../../platforms/reference/energy/tests/bornoracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long double coordinateRounding = 1.5e-7L; /* nm, of distances up to 1 nm */
static const long double energyRounding = 2e-6L;       /* of the terms of a pair */

enum { COEFFICIENTS = SHIFT_TERMS, NODES = 64 };

/* e^-x as the stand-in has it. */
static long double decay(long double x)
{
    const float c[] = STANDIN_EXP;
    const long double n = rintl(x / logl(2));
    const long double r = x - n * logl(2);
    return ldexpl(c[0] + r * (c[1] + r * (c[2] + r * c[3])), (int)-n);
}

/* What a pair's Coulomb and Born energy is at the cutoff, per product of charges: a polynomial in ln(B_i B_j), by least
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
    const long double f = sqrtl(r * r + product * decay(r * r / (4 * product)));
    const long double contrast =
        -born->coulomb * (1 / (long double)born->soluteDielectric - decay(born->kappa * f) / born->solventDielectric);
    long double energy =
        (born->kappa == 0 ? oracleContrast(born, f) : contrast) * born->charges[i] * born->charges[j] / f;
    if (excluded)
        return energy;
    const ctNonbonded* n = d->nonbonded;
    const long double sigma = ((long double)n->sigmas[i] + n->sigmas[j]) / 2;
    const long double sixth = powl(sigma / r, 6);
    const long double log = logI + logJ;
    long double atCutoff = 0;
    for (int i = COEFFICIENTS - 1; i >= 0; i--)
        atCutoff = shift->c[i] + log * atCutoff;
    energy += 4 * sqrtl((long double)n->epsilons[i] * n->epsilons[j]) * sixth * (sixth - 1);
    energy += (long double)CT_COULOMB * n->charges[i] * n->charges[j] / r;
    return energy - born->coulomb * born->charges[i] * born->charges[j] * atCutoff;
}

/* Its derivative by either of them, as if the exponential were its own derivative. */
static long double slopeOfPair(const ctEnergyDefinition* d, const Shift* shift, int i, int j, long double r,
                               long double logI, long double logJ, bool excluded)
{
    const ctBorn* born = d->born;
    const long double product = expl(logI + logJ), x = r * r / (4 * product);
    const long double f = sqrtl(r * r + product * decay(x));
    const long double slopeOfF = product * decay(x) * (1 + x) / (2 * f);
    const long double screening = born->kappa == 0 ? 1 : decay(born->kappa * f);
    const long double contrast = 1 / (long double)born->soluteDielectric - screening / born->solventDielectric;
    const long double charges = born->coulomb * born->charges[i] * born->charges[j];
    long double slope =
        charges * slopeOfF * (contrast / (f * f) - born->kappa * screening / born->solventDielectric / f);
    if (!excluded) {
        const long double log = logI + logJ;
        for (int n = 1; n < COEFFICIENTS; n++)
            slope -= charges * n * shift->c[n] * powl(log, n - 1);
    }
    return slope;
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
            sum.doubt += 2 * fabsl(next - energy) + energyRounding * fabsl(energy);
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
