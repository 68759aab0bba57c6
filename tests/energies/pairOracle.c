#include "pairOracle.h"

#include <math.h>
#include <stdbool.h>

/* The library's coordinates (nm) are from the middle of a leaf, whose particles may be some nm apart: what rounding a
 * difference of two of them costs, relative to these. And what rounding a pair's energy costs. */
static const long double coordinateRounding = 1.2e-7L;
static const long double energyRounding = 1e-6L;

static long double switchFactor(const ctNonbonded* d, long double r)
{
    if (!(d->switchingDistance < d->cutoff) || r <= d->switchingDistance)
        return 1;
    long double t = (r - d->switchingDistance) / (d->cutoff - d->switchingDistance);
    return 1 - 10 * powl(t, 3) + 15 * powl(t, 4) - 6 * powl(t, 5);
}

static PairSum pairEnergy(const ctNonbonded* d, int i, int j, long double r)
{
    long double sigma = ((long double)d->sigmas[i] + d->sigmas[j]) / 2;
    long double epsilon = sqrtl((long double)d->epsilons[i] * d->epsilons[j]);
    long double charges = (long double)CT_COULOMB * d->charges[i] * d->charges[j];
    bool hasCutoff = isfinite(d->cutoff);
    long double twelfth = 4 * epsilon * powl(sigma / r, 12), sixth = 4 * epsilon * powl(sigma / r, 6);
    long double coulomb = charges / r;
    long double field = 0;
    if (d->ewaldAlpha > 0)
        field = -charges * erfl((long double)d->ewaldAlpha * r) / r;
    else if (hasCutoff) {
        long double both = 2 * (long double)d->dielectric + 1;
        field =
            charges * ((d->dielectric - 1) / both / powl(d->cutoff, 3) * r * r - 3 * d->dielectric / both / d->cutoff);
    }
    long double energy = (twelfth - sixth) * switchFactor(d, r) + coulomb + field;
    long double size = twelfth + sixth + fabsl(coulomb) + fabsl(charges) / r + fabsl(field);
    long double slope = (12 * twelfth + 6 * sixth + 2 * fabsl(coulomb)) / r + 10 * (twelfth + sixth);
    long double rounding = coordinateRounding * (1 + r);
    PairSum sum = {energy, energyRounding * size + slope * rounding};
    if (hasCutoff && fabsl(r - d->cutoff) < rounding)
        sum.doubt += fabsl(energy);
    if (hasCutoff && r >= d->cutoff)
        sum.energy = 0;
    if (hasCutoff && r >= d->cutoff + rounding)
        sum.doubt = 0;
    return sum;
}

static bool isExcluded(const ctNonbonded* d, int i, int j)
{
    for (int n = 0; n < d->exclusionCount; n++) {
        const int* pair = d->exclusions[n];
        if ((pair[0] == i && pair[1] == j) || (pair[0] == j && pair[1] == i))
            return true;
    }
    return false;
}

PairSum sumAllPairs(const ctNonbonded* d, int particleCount, const double* positions)
{
    PairSum sum = {0, 0};
    for (int i = 0; i < particleCount; i++)
        for (int j = 0; j < i; j++) {
            long double squared = 0;
            for (int axis = 0; axis < 3; axis++) {
                long double apart = (long double)positions[3 * i + axis] - positions[3 * j + axis];
                squared += apart * apart;
            }
            if (isExcluded(d, i, j))
                continue;
            PairSum pair = pairEnergy(d, i, j, sqrtl(squared));
            sum.energy += pair.energy;
            sum.doubt += pair.doubt;
        }
    return sum;
}
