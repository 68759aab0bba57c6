#include "standInOracle.h"

#include "../../platforms/reference/energy/src/standin.h"
#include "../../platforms/reference/energy/tests/bornoracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long double coordinateRounding = 1.5e-7L; /* nm, of distances up to 1 nm */
static const long double energyRounding = 2e-6L;       /* of the terms of a pair */

/* e^-x as the stand-in has it. */
static long double decay(long double x)
{
    const float c[] = STANDIN_POWER;
    const long double n = rintl(x / logl(2));
    const long double r = x / logl(2) - n;
    return ldexpl(c[0] + r * (c[1] + r * (c[2] + r * c[3])), (int)-n);
}

/* A pair's Coulomb and Born energy at the cutoff, per product of charges, as approximated by the library, or its
 * derivative. */
static long double shiftOf(const StandInModel* model, int which, long double logI, long double logJ)
{
    const int begin = which == 0 ? 0 : VALUE_RANK;
    const int end = which == 0 ? VALUE_RANK : SHIFT_RANK;
    long double sum = 0;
    for (int rank = begin; rank < end; rank++) {
        long double product = model->shiftSign[rank];
        for (int side = 0; side < 2; side++) {
            const long double t = ((side == 0 ? logI : logJ) - model->middleLog) * model->perHalfWidth;
            long double value = 0;
            for (int n = SHIFT_TERMS - 1; n >= 0; n--)
                value = model->shift[rank][n] + value * fminl(1, fmaxl(-1, t));
            product *= value;
        }
        sum += product;
    }
    return sum;
}

/* How much of that is taken from a pair at this distance. */
static long double fadeOf(const ctEnergyDefinition* d, long double r)
{
    const float c[] = STANDIN_FADE;
    const long double x = r * r / (d->standIn->pairCutoff * d->standIn->pairCutoff);
    return x * x * (c[0] + x * (c[1] + x * c[2]));
}

long double findWorstShift(const ctEnergyDefinition* d)
{
    StandInModel model = {0};
    long double worst = 0;
    ctStandInFitShift(&model, d);
    for (int i = 0; i <= 40; i++)
        for (int j = 0; j <= 40; j++) {
            const long double logI = logl(0.1L) + i / 40.0L * logl(7), logJ = logl(0.1L) + j / 40.0L * logl(7);
            const long double cutoff = d->standIn->pairCutoff, product = expl(logI + logJ);
            const long double f = sqrtl(cutoff * cutoff + product * expl(-cutoff * cutoff / (4 * product)));
            const long double value = 1 / cutoff + oracleContrast(d->born, f) / d->born->coulomb / f;
            worst = fmaxl(worst, fabsl(shiftOf(&model, 0, logI, logJ) - value));
            const long double h = 1e-3L;
            const long double slope =
                (shiftOf(&model, 0, logI + h, logJ) - shiftOf(&model, 0, logI - h, logJ)) / (2 * h);
            if (i > 0 && i < 40)
                worst = fmaxl(worst, fabsl(shiftOf(&model, 1, logI, logJ) * STANDIN_GRADIENT - slope) / 5);
        }
    return worst;
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

/* The energy of a pair at these ln B. */
static long double energyOfPair(const ctEnergyDefinition* d, const StandInModel* model, int i, int j, long double r,
                                long double logI, long double logJ, bool excluded)
{
    const ctBorn* born = d->born;
    const long double product = expl(logI + logJ);
    const long double f = sqrtl(r * r + product * decay(r * r / (4 * product)));
    const long double contrast =
        -born->coulomb * (1 / (long double)born->soluteDielectric - decay(born->kappa * f) / born->solventDielectric);
    long double energy =
        (born->kappa == 0 ? oracleContrast(born, f) : contrast) * born->charges[i] * born->charges[j] / f;
    energy -= born->coulomb * born->charges[i] * born->charges[j] * fadeOf(d, r) * shiftOf(model, 0, logI, logJ);
    if (excluded)
        return energy;
    const ctNonbonded* n = d->nonbonded;
    const long double sigma = ((long double)n->sigmas[i] + n->sigmas[j]) / 2;
    const long double sixth = powl(sigma / r, 6);
    energy += 4 * sqrtl((long double)n->epsilons[i] * n->epsilons[j]) * sixth * (sixth - 1);
    return energy + (long double)CT_COULOMB * n->charges[i] * n->charges[j] / r;
}

/* Its derivative by either of them, as if the exponential were its own derivative. */
static long double slopeOfPair(const ctEnergyDefinition* d, const StandInModel* model, int i, int j, long double r,
                               long double logI, long double logJ)
{
    const ctBorn* born = d->born;
    const long double product = expl(logI + logJ), x = r * r / (4 * product);
    const long double f = sqrtl(r * r + product * decay(x));
    const long double slopeOfF = product * decay(x) * (1 + x) / (2 * f);
    const long double screening = born->kappa == 0 ? 1 : decay(born->kappa * f);
    const long double contrast = 1 / (long double)born->soluteDielectric - screening / born->solventDielectric;
    const long double charges = born->coulomb * born->charges[i] * born->charges[j];
    const long double slope =
        charges * slopeOfF * (contrast / (f * f) - born->kappa * screening / born->solventDielectric / f);
    return slope - charges * fadeOf(d, r) * shiftOf(model, 1, logI, logJ) * STANDIN_GRADIENT;
}

void setStandInBox(const double (*box)[3])
{
    oracleBox = box;
}

/* Lennard-Jones, and Coulomb with a reaction field. */
static long double nonbondedOfPair(const ctNonbonded* n, int i, int j, long double r)
{
    const long double cutoff = n->cutoff, sixth = powl((n->sigmas[i] + (long double)n->sigmas[j]) / 2 / r, 6);
    const long double k = (n->dielectric - 1) / (2 * n->dielectric + 1) / powl(cutoff, 3);
    const long double c = 3 * n->dielectric / (2 * n->dielectric + 1) / cutoff;
    return 4 * sqrtl((long double)n->epsilons[i] * n->epsilons[j]) * sixth * (sixth - 1) +
           (long double)CT_COULOMB * n->charges[i] * n->charges[j] * (1 / r + k * r * r - c);
}

WholeSum sumWhole(const ctEnergyDefinition* d, int particleCount, const double* positions)
{
    WholeSum sum = {0, 0, 1};
    long double* radii = malloc((size_t)particleCount * sizeof *radii);
    if (radii == NULL)
        abort();
    for (int i = 0; i < particleCount; i++) {
        radii[i] = oracleBornRadius(d->born, i, oracleBornSum(d->born, particleCount, positions, i, d->born->cutoff));
        sum.born += oracleBornSelf(d->born, i, radii[i]);
        sum.size += fabsl(oracleBornSelf(d->born, i, radii[i]));
    }
    for (int i = 0; i < particleCount; i++)
        for (int j = 0; j < i; j++) {
            const long double r = oracleDistance(positions, i, j);
            if (r < d->born->cutoff) {
                const long double born = oracleBornPair(d->born, i, j, r, radii[i], radii[j]);
                sum.born += born;
                sum.size += fabsl(born) * (1 + 1 / r);
            }
            if (r < d->nonbonded->cutoff && !isExcluded(d->nonbonded, i, j)) {
                const long double nonbonded = nonbondedOfPair(d->nonbonded, i, j, r);
                sum.nonbonded += nonbonded;
                sum.size += fabsl(nonbonded) * (1 + 12 / r);
            }
        }
    free(radii);
    return sum;
}

StandInSum sumStandIn(const ctEnergyDefinition* d, int particleCount, const double* positions, const double* far)
{
    StandInSum sum = {0};
    StandInModel model = {0};
    ctStandInFitShift(&model, d);
    long double* logs = malloc(2 * (size_t)particleCount * sizeof *logs);
    long double* beyond = logs + particleCount;
    if (logs == NULL)
        abort();
    for (int i = 0; i < particleCount; i++) {
        const long double born = far[i] + oracleBornSum(d->born, particleCount, positions, i, d->standIn->bornCutoff) -
                                 oracleBornTaken(d->born, particleCount, positions, i, d->standIn->bornCutoff);
        const long double radius = oracleBornRadius(d->born, i, born);
        const long double log = logl(radius);
        const long double charge = fabsl((long double)d->born->charges[i]);
        const long double factor = powl(charge / STANDIN_GRID_CHARGE, STANDIN_GRID_POWER);
        const long double width = (float)(d->standIn->gridWidth * fminl(factor, STANDIN_WIDEST_GRID));
        logs[i] = width * rintl(log / width);
        beyond[i] = log - logs[i];
        sum.isAmbiguous |= fabsl(fabsl(beyond[i]) - width / 2) < 2e-5L || !(radius > 0 && radius < 90);
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
            const long double energy = energyOfPair(d, &model, i, j, r, logs[i], logs[j], excluded);
            const long double next = energyOfPair(d, &model, i, j, r + coordinateRounding, logs[i], logs[j], excluded);
            sum.doubt += 2 * fabsl(next - energy) + energyRounding * fabsl(energy);
            sum.doubt += energyRounding * 1000 * fabsl((long double)d->born->charges[i] * d->born->charges[j]) / r;
            sum.isAmbiguous |= fabsl(r - cutoff) < coordinateRounding || r < 0.002L || energy > 1e5L;
            if (r >= cutoff)
                continue;
            sum.energy += energy;
            sum.energy += beyond[i] * slopeOfPair(d, &model, i, j, r, logs[i], logs[j]);
            sum.energy += beyond[j] * slopeOfPair(d, &model, j, i, r, logs[j], logs[i]);
            sum.doubt += (fabsl(beyond[i]) + fabsl(beyond[j])) / 1000;
        }
    free(logs);
    return sum;
}
