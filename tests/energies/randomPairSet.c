#include "randomPairSet.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "pairKinds.h"

/* ---- Random choices ---- */

static void chooseParameters(randomPairSet* set, randomSource* random, int particleCount)
{
    set->parameters = allocateZeros((size_t)particleCount * PAIR_PARAMETERS, sizeof(double));
    for (int i = 0; i < particleCount; i++) {
        double* p = set->parameters + PAIR_PARAMETERS * i;
        p[SIGMA] = randomReal(random, 0.01, 0.2);
        p[EPSILON] = randomChance(random, 0.2) ? 0 : randomReal(random, 0, 1);
        p[CHARGE] = randomChance(random, 0.1) ? 0 : randomReal(random, -1, 1);
        p[TYPE] = randomInt(random, PAIR_TYPES);
    }
    set->set.parametersPerParticle = PAIR_PARAMETERS;
    set->set.parameters = set->parameters;
}

static void chooseExclusions(randomPairSet* set, randomSource* random, int particleCount)
{
    int count = randomChance(random, 0.2) ? 0 : randomInt(random, 3 * particleCount);
    set->exclusions = allocateZeros((size_t)count, sizeof *set->exclusions);
    for (int n = 0; n < count; n++) {
        set->exclusions[n][0] = randomInt(random, particleCount);
        set->exclusions[n][1] = (set->exclusions[n][0] + randomInt(random, 4)) % particleCount;
    }
    set->set.exclusionCount = count;
    set->set.exclusions = (const int(*)[2])set->exclusions;
}

static void chooseGroups(randomPairSet* set, randomSource* random, int particleCount)
{
    int count = randomChance(random, 0.5) ? 0 : 1 + randomInt(random, 4);
    set->groups = allocateZeros((size_t)count, sizeof *set->groups);
    for (int g = 0; g < count; g++)
        for (int side = 0; side < 2; side++) {
            double share = randomReal(random, 0, 1);
            int* members = allocateZeros((size_t)particleCount, sizeof(int));
            int* size = &set->groups[g].counts[side];
            for (int i = 0; i < particleCount; i++)
                if (randomChance(random, share))
                    members[(*size)++] = i;
            set->groups[g].particles[side] = members;
        }
    set->set.groupCount = count;
    set->set.groups = set->groups;
}

void randomPairSetCreate(randomPairSet* set, randomSource* random, int particleCount)
{
    memset(set, 0, sizeof *set);
    const PairKind* kind = &pairKinds[randomInt(random, PAIR_KINDS)];
    set->formula = kind->formula;
    if (kind->makeTables != NULL)
        kind->makeTables(set, random);
    kind->write(set);
    set->set.operationCount = set->operationCount;
    set->set.operations = set->operations;
    set->set.tables = set->tables;
    set->set.cutoff = randomChance(random, 0.3) ? INFINITY : randomReal(random, 0.2, 1.5);
    set->set.switchingDistance = randomReal(random, 0.4, 1.4) * (isfinite(set->set.cutoff) ? set->set.cutoff : 1);
    chooseParameters(set, random, particleCount);
    chooseExclusions(set, random, particleCount);
    chooseGroups(set, random, particleCount);
}

void randomPairSetDestroy(randomPairSet* set)
{
    for (int g = 0; g < set->set.groupCount; g++)
        for (int side = 0; side < 2; side++)
            free((void*)set->groups[g].particles[side]);
    for (int table = 0; table < MOST_PAIR_TABLES; table++)
        free(set->values[table]);
    free(set->parameters);
    free(set->exclusions);
    free(set->groups);
}

/* ---- The oracle ---- */

static bool isIn(int count, const int* particles, int particle)
{
    for (int i = 0; i < count; i++)
        if (particles[i] == particle)
            return true;
    return false;
}

static int countTimes(const ctPairSet* set, int i, int j)
{
    for (int n = 0; n < set->exclusionCount; n++)
        if ((set->exclusions[n][0] == i && set->exclusions[n][1] == j) ||
            (set->exclusions[n][0] == j && set->exclusions[n][1] == i))
            return 0;
    int times = set->groupCount == 0;
    for (int g = 0; g < set->groupCount; g++) {
        const ctInteractionGroup* group = &set->groups[g];
        bool inFirst[2] = {isIn(group->counts[0], group->particles[0], i),
                           isIn(group->counts[0], group->particles[0], j)};
        bool inSecond[2] = {isIn(group->counts[1], group->particles[1], i),
                            isIn(group->counts[1], group->particles[1], j)};
        times += (inFirst[0] && inSecond[1]) || (inFirst[1] && inSecond[0]);
    }
    return times;
}

static long double switchFactor(const ctPairSet* set, long double r)
{
    if (!(set->switchingDistance < set->cutoff) || r <= set->switchingDistance)
        return 1;
    long double t = (r - set->switchingDistance) / (set->cutoff - set->switchingDistance);
    return 1 - 10 * powl(t, 3) + 15 * powl(t, 4) - 6 * powl(t, 5);
}

/* As in pairOracle.c. */
static const long double coordinateRounding = 1.2e-7L;
static const long double energyRounding = 3e-6L;

static PairSum pairEnergy(const randomPairSet* set, int i, int j, long double r)
{
    const ctPairSet* d = &set->set;
    const double* first = d->parameters + PAIR_PARAMETERS * i;
    const double* second = d->parameters + PAIR_PARAMETERS * j;
    long double rounding = coordinateRounding * (1 + r);
    if (isfinite(d->cutoff) && r >= d->cutoff + rounding)
        return (PairSum){0, 0};
    PairValue value = set->formula(set, r, first, second);
    long double factor = switchFactor(d, r);
    PairSum sum = {value.energy * factor, energyRounding * value.size + 10 * rounding * value.size};
    /* The slope, and jumps, from values around; a distance of 0 has no neighbour below. */
    for (int side = -1; side <= 1; side += 2) {
        long double beside = fmaxl(r + side * 2 * rounding, r / 2);
        sum.doubt += fabsl(set->formula(set, beside, first, second).energy * switchFactor(d, beside) - sum.energy);
    }
    if (isfinite(d->cutoff) && fabsl(r - d->cutoff) < rounding)
        sum.doubt += fabsl(sum.energy);
    if (isfinite(d->cutoff) && r >= d->cutoff)
        sum.energy = 0;
    return sum;
}

PairSum sumPairSet(const randomPairSet* set, int particleCount, const double* positions)
{
    PairSum sum = {0, 0};
    for (int i = 0; i < particleCount; i++)
        for (int j = 0; j < i; j++) {
            int times = countTimes(&set->set, i, j);
            if (times == 0)
                continue;
            long double squared = 0;
            for (int axis = 0; axis < 3; axis++) {
                long double apart = (long double)positions[3 * i + axis] - positions[3 * j + axis];
                squared += apart * apart;
            }
            PairSum pair = pairEnergy(set, i, j, sqrtl(squared));
            sum.energy += times * pair.energy;
            sum.doubt += times * pair.doubt;
        }
    return sum;
}
