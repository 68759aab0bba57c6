#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Lists ---- */

void compareClashes(Program* p)
{
    Expected expected = expectedClashes(p);
    PairList list = {0};
    ctCounts counts;
    bool clash;
    int pair[2] = {CT_NULL, CT_NULL};
    SUCCEED(ctForEachClash(p->tree, collectPair, &list, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    requireSameList(p, &list, &expected, 1);
    SUCCEED(ctHasClash(p->tree, &clash, pair, NULL));
    require(clash == (list.count > 0), p, "ctHasClash says %d; %d pairs are listed", clash, list.count);
    require(!clash || findPair(&list, pair[0], pair[1]) != NULL, p, "%d-%d is in no list", pair[0], pair[1]);
    p->tally->clashes += list.count;
    free(list.pairs);
    expectedDestroy(&expected);
}

/* Arrays of a random capacity hold pairs of the list. */
static void compareNeighborArrays(Program* p, double cutoff, PairList* list)
{
    size_t capacity = (size_t)randomInt(&p->random, list->count + 10), count = 0;
    int *lower = programAllocate((int)capacity, sizeof(int)), *higher = programAllocate((int)capacity, sizeof(int));
    double* distances = programAllocate((int)capacity, sizeof(double));
    bool measured = randomChance(&p->random, 0.7), sorted = randomChance(&p->random, 0.5);
    SUCCEED(ctGetNeighborPairs(p->tree, cutoff, sorted, capacity, lower, higher, measured ? distances : NULL, &count,
                               NULL));
    require(count == (size_t)list->count, p, "%zu pairs in arrays, %d in a list", count, list->count);
    sortCollected(p, list);
    for (size_t i = 0; i < count && i < capacity; i++) {
        const Pair* nth = list->pairs + i;
        require(!sorted || count > capacity || (nth->particles[0] == lower[i] && nth->particles[1] == higher[i]), p,
                "%d-%d is at the wrong place", lower[i], higher[i]);
        const Pair* same = findPair(list, lower[i], higher[i]);
        require(same != NULL && lower[i] < higher[i], p, "%d-%d is in no list", lower[i], higher[i]);
        require(!measured || distances[i] == same->values[0], p, "%d-%d: %.17g in an array, %.17g in a list", lower[i],
                higher[i], distances[i], same->values[0]);
    }
    free(lower);
    free(higher);
    free(distances);
}

void compareNeighborPairs(Program* p)
{
    double cutoff = chooseCutoff(p);
    int count = oracleListNeighborPairs(p->oracle, cutoff + DOUBT, 0, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListNeighborPairs(p->oracle, cutoff + DOUBT, count, expected.particles, expected.values);
    for (int e = 0; e < count; e++)
        expected.margins[e] = cutoff - expected.values[e];
    PairList list = {0};
    ctCounts counts;
    SUCCEED(ctForEachNeighborPair(p->tree, cutoff, collectPair, &list, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    requireSameList(p, &list, &expected, 1);
    compareNeighborArrays(p, cutoff, &list);
    p->tally->neighbors += list.count;
    free(list.pairs);
    expectedDestroy(&expected);
}

void compareProbe(Program* p)
{
    double position[3], kind = randomReal(&p->random, 0, 1);
    double radius = kind < 0.2    ? 0
                    : kind < 0.25 ? pow(10, randomReal(&p->random, 0, 3))
                                  : randomReal(&p->random, 0, 0.5);
    memcpy(position, p->state + 3 * chooseParticle(p), sizeof position);
    for (int axis = 0; axis < 3; axis++)
        position[axis] += randomReal(&p->random, -0.3, 0.3);
    int count = oracleListClashesWith(p->oracle, position, radius, DOUBT, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    int* particles = programAllocate(count, sizeof(int));
    oracleListClashesWith(p->oracle, position, radius, DOUBT, count, particles, expected.values, expected.margins);
    for (int e = 0; e < count; e++)
        expected.particles[2 * e] = expected.particles[2 * e + 1] = particles[e];
    PairList list = {0};
    ctCounts counts;
    SUCCEED(ctForEachClashWith(p->tree, position, radius, collectParticle, &list, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    requireSameList(p, &list, &expected, 1);
    free(particles);
    free(list.pairs);
    expectedDestroy(&expected);
}

/* Of a list that ends early, what came is as long as asked for and part of the whole. */
static void requireBeginning(const Program* p, PairList* all, PairList* some)
{
    int wanted = all->count < some->end ? all->count : some->end;
    require(some->count == wanted, p, "%d pairs came, not %d", some->count, wanted);
    sortCollected(p, all);
    for (int n = 0; n < some->count; n++)
        require(findPair(all, some->pairs[n].particles[0], some->pairs[n].particles[1]) != NULL, p,
                "a pair came that is not in the whole list");
    all->count = some->count = 0;
}

void endListsEarly(Program* p)
{
    PairList all = {0}, some = {.end = 1 + randomInt(&p->random, 3)};
    double cutoff = chooseCutoff(p);
    SUCCEED(ctForEachNeighborPair(p->tree, cutoff, collectPair, &all, NULL));
    SUCCEED(ctForEachNeighborPair(p->tree, cutoff, collectPair, &some, NULL));
    requireBeginning(p, &all, &some);
    SUCCEED(ctForEachClash(p->tree, collectPair, &all, NULL));
    SUCCEED(ctForEachClash(p->tree, collectPair, &some, NULL));
    requireBeginning(p, &all, &some);
    SUCCEED(ctForEachClashWith(p->tree, p->state, fmin(cutoff, 100), collectParticle, &all, NULL));
    SUCCEED(ctForEachClashWith(p->tree, p->state, fmin(cutoff, 100), collectParticle, &some, NULL));
    requireBeginning(p, &all, &some);
    if (p->hasTrial) {
        SUCCEED(ctForEachChangedPair(p->tree, cutoff, collectChangedPair, &all, NULL));
        SUCCEED(ctForEachChangedPair(p->tree, cutoff, collectChangedPair, &some, NULL));
        requireBeginning(p, &all, &some);
    }
    requireUntouchedState(p);
    free(all.pairs);
    free(some.pairs);
}

/* ---- Numbers ---- */

/* A few particles with repeats, or an interval. */
static KeptSet chooseSet(Program* p)
{
    bool interval = randomChance(&p->random, 0.5);
    int first = chooseParticle(p);
    KeptSet set = {.count = 1 + randomInt(&p->random, interval ? p->scene.particleCount - first : 20)};
    set.particles = programAllocate(set.count, sizeof(int));
    for (int n = 0; n < set.count; n++)
        set.particles[n] = interval ? first + n : chooseParticle(p);
    SUCCEED(ctSelect(p->tree, set.count, set.particles, &set.selection));
    return set;
}

/* The kept set, if there is one, or another. */
static KeptSet takeSet(Program* p)
{
    if (p->kept.selection == NULL || randomChance(&p->random, 0.5))
        return chooseSet(p);
    KeptSet kept = p->kept;
    p->kept = (KeptSet){0};
    return kept;
}

static void returnSet(Program* p, KeptSet* set)
{
    if (p->kept.selection == NULL && !set->isStale)
        p->kept = *set;
    else
        freeSet(set);
}

static bool isInSet(const KeptSet* set, int particle)
{
    int n = 0;
    while (n < set->count && set->particles[n] != particle)
        n++;
    return n < set->count;
}

void compareMinimumDistance(Program* p)
{
    KeptSet a = takeSet(p), b = takeSet(p);
    int pair[2] = {CT_NULL, CT_NULL};
    double distance, expected = oracleMinimumDistance(p->oracle, a.count, a.particles, b.count, b.particles);
    bool isRefused = a.isStale || b.isStale || isinf(expected);
    ctCounts cost;
    ctStatus status = ctGetMinimumDistance(p->tree, a.selection, b.selection, &distance, pair, chooseCounts(p, &cost));
    requireCounted(p, &cost);
    requireStatus(p, "ctGetMinimumDistance", status, isRefused ? ctInvalidArgument : ctSuccess);
    if (!isRefused) {
        require(isInSet(&a, pair[0]) && isInSet(&b, pair[1]) && pair[0] != pair[1], p, "the nearest pair is %d-%d",
                pair[0], pair[1]);
        requireNear(p, "least distance", 0, distance, expected, numberTolerance(p));
        requireNear(p, "distance of the nearest pair", 0, oracleDistance(p->oracle, ORACLE_STATE, pair[0], pair[1]),
                    expected, numberTolerance(p));
        /* Now the search begins with the pair that was nearest. */
        double again;
        int samePair[2];
        SUCCEED(ctGetMinimumDistance(p->tree, a.selection, b.selection, &again, samePair, NULL));
        require(again == distance && samePair[0] == pair[0] && samePair[1] == pair[1], p,
                "the nearest pair is %d-%d, asked again %d-%d", pair[0], pair[1], samePair[0], samePair[1]);
    }
    returnSet(p, &a);
    returnSet(p, &b);
}

/* The direction between two particles is as uncertain as their positions; but that of a force between particles which
 * the caller has put at one place is fixed. */
static double directionError(const Program* p, int i, int j)
{
    double distance = oracleDistance(p->oracle, ORACLE_STATE, i, j);
    if (distance == 0)
        return hasParticleMoved(p, i) || hasParticleMoved(p, j) ? 2 : 0;
    return fmin(2, 2 * numberTolerance(p) / distance);
}

void compareEnergy(Program* p)
{
    const double k = randomReal(&p->random, 0.1, 1e5);
    Expected clashes = expectedClashes(p);
    double* expected = programAllocate(coordinateCount(p), sizeof(double));
    double* forces = programAllocate(coordinateCount(p), sizeof(double));
    double* errors = programAllocate(p->scene.particleCount, sizeof(double));
    double energyError = 0, energy, energyWithForces, expectedEnergy = oracleEnergy(p->oracle, k, expected);
    for (int e = 0; e < clashes.count; e++) {
        const int i = clashes.particles[2 * e], j = clashes.particles[2 * e + 1];
        double depth = fabs(clashes.margins[e]);
        double depthError = numberTolerance(p) + (depth <= DOUBT ? DOUBT : 0); /* either answer is right there */
        errors[i] += k * (depthError + depth * directionError(p, i, j));
        errors[j] += k * (depthError + depth * directionError(p, i, j));
        energyError += k * (depth + depthError) * depthError;
    }
    ctCounts counts;
    SUCCEED(ctComputeEnergy(p->tree, k, &energy, NULL, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    requireNear(p, "energy", 0, energy, expectedEnergy, energyError + 1e-13 * expectedEnergy);
    for (int n = 0; n < coordinateCount(p); n++)
        forces[n] = n % 7; /* to be added to */
    SUCCEED(ctComputeEnergy(p->tree, k, &energyWithForces, forces, NULL));
    require(energyWithForces == energy, p, "the energy is another with forces");
    for (int n = 0; n < coordinateCount(p); n++)
        requireNear(p, "force component", n, forces[n] - n % 7, expected[n],
                    errors[n / 3] + 1e-12 * (1 + fabs(expected[n])));
    expectedDestroy(&clashes);
    free(expected);
    free(forces);
    free(errors);
}
