#define _POSIX_C_SOURCE 200809L /* setenv */

#include "hardcase.h"

#include "programs/pairs.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Within this of a limit either answer is right, as long as all engines give the same. */
#define DOUBT (0.99 * CT_SIGMA)

/* nm: a pair whose distance a trial changes by no more may be listed as changed or not. */
#define COUNTS_AS_UNMOVED 2.1e-11

#define PI 3.14159265358979323846

#define SUCCEED(hard, engine, call)                                                                                    \
    need((call) == ctSuccess, hard, "%s fails: %s", #call, ctGetErrorText((hard)->engines[engine]))

void need(bool condition, const HardCase* hard, const char* format, ...)
{
    if (condition)
        return;
    va_list arguments;
    va_start(arguments, format);
    printf("%s: ", hard->name);
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
    exit(1);
}

/* Whose answer differs from the first one's. */
static const char* engineName(int engine)
{
    static const char* const names[] = {"avx512, tree",     "avx512, boxes",        "avx512, clearances",
                                        "avx512, by cost",  "avx2, tree",           "avx2, boxes",
                                        "avx2, clearances", "avx2, by cost",        "portable, tree",
                                        "portable, boxes",  "portable, clearances", "portable, by cost"};
    return names[engine];
}

static void* allocate(size_t count, size_t size)
{
    void* memory = calloc(count > 0 ? count : 1, size);
    if (memory == NULL)
        abort();
    return memory;
}

static size_t coordinateCount(const HardCase* hard)
{
    return 3 * (size_t)hard->scene->particleCount;
}

/* ---- Life ---- */

static void openEngines(HardCase* hard)
{
    static const char* const sets[] = {"avx512", "avx2", "portable"};
    static const char* const courses[] = {"tree", "boxes", "clearances", "cost"};
    const ctDefinition definition = sceneDefinition(hard->scene);
    for (int engine = 0; engine < MOST_ENGINES; engine++) {
        setenv("CHAINTREE_SIMD", sets[engine / 4], 1);
        setenv("CHAINTREE_TRIALS", courses[engine % 4], 1);
        char text[256] = "";
        const ctStatus status = ctCreate(&definition, &hard->engines[engine], text, sizeof text);
        need(status == ctSuccess, hard, "ctCreate fails: %s", text);
        hard->engineCount++;
    }
}

static void measureErrors(HardCase* hard)
{
    const Scene* scene = hard->scene;
    double farthest = 0, least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t n = 0; n < coordinateCount(hard); n++) {
        farthest = fmax(farthest, fabs(scene->positions[n]));
        least[n % 3] = fmin(least[n % 3], scene->positions[n]);
        most[n % 3] = fmax(most[n % 3], scene->positions[n]);
    }
    double size = 1;
    for (int axis = 0; axis < 3 && scene->particleCount > 0; axis++)
        size += most[axis] - least[axis];
    hard->distanceError = 1e-12 * size;
    hard->positionError = hard->distanceError + 2.3e-16 * farthest;
}

void openCase(HardCase* hard, const char* name, Scene* scene)
{
    *hard = (HardCase){.name = name, .scene = scene};
    openEngines(hard);
    measureErrors(hard);
    hard->oracle = oracleCreate(scene->particleCount, scene->positions, scene->radii, NULL, scene->particleLinks,
                                scene->linkCount, scene->linkParents, scene->linkJoints, *scene->linkTorsions,
                                scene->exclusionCount, *scene->exclusions, scene->overlapTolerance, 0);
    hard->state = allocate(ctGetStateSize(hard->engines[0]), sizeof(double));
    hard->positions = allocate(coordinateCount(hard), sizeof(double));
    hard->others = allocate(coordinateCount(hard), sizeof(double));
    ctGetState(hard->engines[0], hard->state);
}

void closeCase(HardCase* hard)
{
    for (int engine = 0; engine < hard->engineCount; engine++)
        ctDestroy(hard->engines[engine]);
    oracleDestroy(hard->oracle);
    free(hard->state);
    free(hard->positions);
    free(hard->others);
}

/* ---- Positions and state ---- */

static void needOraclePositions(HardCase* hard, int which)
{
    oracleGetPositions(hard->oracle, which, hard->others);
    for (size_t n = 0; n < coordinateCount(hard); n++)
        need(fabs(hard->positions[n] - hard->others[n]) <= hard->positionError, hard,
             "coordinate %zu of particle %zu is %.17g, not %.17g", n % 3, n / 3, hard->positions[n], hard->others[n]);
}

static void needSameBits(const HardCase* hard, int engine, const char* what, const double* values,
                         const double* expected, size_t count)
{
    for (size_t n = 0; n < count; n++)
        need(memcmp(values + n, expected + n, sizeof(double)) == 0, hard, "%s %zu is %.17g by %s, not %.17g", what, n,
             values[n], engineName(engine), expected[n]);
}

static void comparePositions(HardCase* hard)
{
    ctGetPositions(hard->engines[0], hard->positions);
    for (int engine = 1; engine < hard->engineCount; engine++) {
        ctGetPositions(hard->engines[engine], hard->others);
        needSameBits(hard, engine, "coordinate", hard->others, hard->positions, coordinateCount(hard));
    }
    needOraclePositions(hard, ORACLE_STATE);
}

static void needSameState(HardCase* hard)
{
    const size_t size = ctGetStateSize(hard->engines[0]);
    double* state = allocate(size, sizeof(double));
    for (int engine = 0; engine < hard->engineCount; engine++) {
        ctGetState(hard->engines[engine], state);
        needSameBits(hard, engine, "number of the state", state, hard->state, size);
    }
    free(state);
}

/* ---- Trials ---- */

static void proposeToOracle(HardCase* hard, int count, const ctChange* changes)
{
    int* links = allocate((size_t)count, sizeof(int));
    double* flat = allocate((size_t)count, sizeof(double[ORACLE_CHANGE_SIZE]));
    for (int n = 0; n < count; n++) {
        double* numbers = flat + ORACLE_CHANGE_SIZE * n;
        links[n] = changes[n].link;
        numbers[0] = changes[n].angle;
        memcpy(numbers + 1, changes[n].rotation, sizeof(double[3]));
        memcpy(numbers + 4, changes[n].pivot, sizeof(double[3]));
        memcpy(numbers + 7, changes[n].translation, sizeof(double[3]));
    }
    oraclePropose(hard->oracle, count, links, flat);
    free(links);
    free(flat);
}

static void needOracleVerdict(HardCase* hard, bool clash, const int pair[2])
{
    int worst[2] = {CT_NULL, CT_NULL};
    const double margin = oracleWorstTrialMargin(hard->oracle, worst);
    need(clash || margin <= DOUBT, hard, "called clash-free; %d-%d is %g beyond its limit", worst[0], worst[1], margin);
    if (clash) {
        const double own = oracleLimitMargin(hard->oracle, ORACLE_TRIAL, pair[0], pair[1]);
        need(own > -DOUBT, hard, "called clashing at %d-%d, which is %g within its limit", pair[0], pair[1], -own);
        need(oracleIsPairChanged(hard->oracle, pair[0], pair[1]), hard, "%d-%d moves as one body", pair[0], pair[1]);
    }
    hard->doubtful += fabs(margin) <= DOUBT;
    hard->clashing += clash;
    hard->clashFree += !clash;
}

bool tryChanges(HardCase* hard, int count, const ctChange* changes)
{
    bool expected = false;
    proposeToOracle(hard, count, changes);
    for (int engine = 0; engine < hard->engineCount; engine++) {
        ctChainTree* tree = hard->engines[engine];
        bool clash = false;
        int pair[2] = {CT_NULL, CT_NULL};
        SUCCEED(hard, engine, ctPropose(tree, count, changes));
        SUCCEED(hard, engine, ctTestTrial(tree, &clash, pair, NULL));
        if (engine == 0) {
            expected = clash;
            needOracleVerdict(hard, clash, pair);
        }
        need(clash == expected, hard, "%s says %d to link %d turned by %.17g, %s %d", engineName(engine), clash,
             count > 0 ? changes[0].link : CT_NULL, count > 0 ? changes[0].angle : 0, engineName(0), expected);
    }
    return expected;
}

bool tryTurn(HardCase* hard, int link, double angle)
{
    const ctChange change = {.link = link, .angle = angle};
    return tryChanges(hard, 1, &change);
}

bool tryShift(HardCase* hard, int link, double x, double y, double z)
{
    const ctChange change = {.link = link, .translation = {x, y, z}};
    return tryChanges(hard, 1, &change);
}

void acceptTrial(HardCase* hard)
{
    SUCCEED(hard, 0, ctGetTrialPositions(hard->engines[0], hard->positions));
    needOraclePositions(hard, ORACLE_TRIAL);
    for (int engine = 0; engine < hard->engineCount; engine++) {
        SUCCEED(hard, engine, ctAccept(hard->engines[engine], NULL));
        ctGetPositions(hard->engines[engine], hard->others);
        needSameBits(hard, engine, "coordinate", hard->others, hard->positions, coordinateCount(hard));
    }
    oracleAccept(hard->oracle);
    ctGetState(hard->engines[0], hard->state);
    needSameState(hard);
}

void dropTrial(HardCase* hard)
{
    for (int engine = 0; engine < hard->engineCount; engine++)
        ctReject(hard->engines[engine]);
    oracleReject(hard->oracle);
    needSameState(hard);
}

/* ---- Lists of pairs ---- */

/* An oracle's list with the slack that DOUBT needs: values, and how far each is beyond the limit. */
typedef struct Expected {
    int count;
    int* particles;
    double *values, *others, *margins;
} Expected;

static Expected expectedCreate(int capacity)
{
    const size_t size = (size_t)capacity;
    return (Expected){capacity, allocate(2 * size, sizeof(int)), allocate(size, sizeof(double)),
                      allocate(size, sizeof(double)), allocate(size, sizeof(double))};
}

static void expectedDestroy(Expected* expected)
{
    free(expected->particles);
    free(expected->values);
    free(expected->others);
    free(expected->margins);
}

static void needOracleList(const HardCase* hard, const char* what, const PairList* list, const Expected* expected)
{
    int n = 0;
    for (int e = 0; e < expected->count; e++) {
        const int* pair = expected->particles + 2 * e;
        const bool isListed = n < list->count && memcmp(list->pairs[n].particles, pair, sizeof(int[2])) == 0;
        need(isListed || expected->margins[e] <= DOUBT, hard, "%s: %d-%d is missing; it is %g beyond the limit", what,
             pair[0], pair[1], expected->margins[e]);
        if (!isListed)
            continue;
        const double value = list->pairs[n++].values[0];
        need(fabs(value - expected->values[e]) <= hard->distanceError, hard, "%s: %d-%d has %.17g, not %.17g", what,
             pair[0], pair[1], value, expected->values[e]);
    }
    need(n == list->count, hard, "%s: %d-%d should not be there", what,
         n < list->count ? list->pairs[n].particles[0] : 0, n < list->count ? list->pairs[n].particles[1] : 0);
}

static void needSameList(const HardCase* hard, const char* what, int engine, const PairList* list,
                         const PairList* expected)
{
    need(list->count == expected->count, hard, "%s: %d pairs by %s, %d by %s", what, list->count, engineName(engine),
         expected->count, engineName(0));
    for (int n = 0; n < list->count; n++)
        need(memcmp(&list->pairs[n], &expected->pairs[n], sizeof(Pair)) == 0, hard,
             "%s: %d-%d with %.17g by %s, %d-%d with %.17g by %s", what, list->pairs[n].particles[0],
             list->pairs[n].particles[1], list->pairs[n].values[0], engineName(engine), expected->pairs[n].particles[0],
             expected->pairs[n].particles[1], expected->pairs[n].values[0], engineName(0));
}

typedef ctStatus ListFunction(ctChainTree* tree, double cutoff, PairList* list);

static ctStatus listClashes(ctChainTree* tree, double cutoff, PairList* list)
{
    (void)cutoff;
    return ctForEachClash(tree, collectPair, list, NULL);
}

static ctStatus listNeighbors(ctChainTree* tree, double cutoff, PairList* list)
{
    return ctForEachNeighborPair(tree, cutoff, collectPair, list, NULL);
}

static ctStatus listChanged(ctChainTree* tree, double cutoff, PairList* list)
{
    return ctForEachChangedPair(tree, cutoff, collectChangedPair, list, NULL);
}

/* The list of the first engine, sorted, is left to the caller. */
static PairList compareLists(HardCase* hard, const char* what, double cutoff, ListFunction* listOf,
                             const Expected* expected)
{
    PairList first = {0};
    for (int engine = 0; engine < hard->engineCount; engine++) {
        PairList list = {0};
        SUCCEED(hard, engine, listOf(hard->engines[engine], cutoff, &list));
        const Pair* twice = sortPairs(&list);
        need(twice == NULL, hard, "%s: %d-%d comes twice", what, twice != NULL ? twice->particles[0] : 0,
             twice != NULL ? twice->particles[1] : 0);
        if (engine == 0) {
            needOracleList(hard, what, &list, expected);
            first = list;
            continue;
        }
        needSameList(hard, what, engine, &list, &first);
        free(list.pairs);
    }
    return first;
}

void compareChangedPairs(HardCase* hard, double cutoff)
{
    const int count = oracleListChangedPairs(hard->oracle, cutoff + DOUBT, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListChangedPairs(hard->oracle, cutoff + DOUBT, count, expected.particles, expected.values, expected.others);
    for (int e = 0; e < count; e++)
        expected.margins[e] = fabs(expected.values[e] - expected.others[e]) <= COUNTS_AS_UNMOVED
                                  ? 0
                                  : cutoff - fmin(expected.values[e], expected.others[e]);
    PairList list = compareLists(hard, "changed pairs", cutoff, listChanged, &expected);
    free(list.pairs);
    expectedDestroy(&expected);
}

static void compareNeighbors(HardCase* hard, double cutoff)
{
    const int count = oracleListNeighborPairs(hard->oracle, cutoff + DOUBT, 0, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListNeighborPairs(hard->oracle, cutoff + DOUBT, count, expected.particles, expected.values);
    for (int e = 0; e < count; e++)
        expected.margins[e] = cutoff - expected.values[e];
    PairList list = compareLists(hard, "neighbour pairs", cutoff, listNeighbors, &expected);
    free(list.pairs);
    expectedDestroy(&expected);
}

static void compareClashes(HardCase* hard)
{
    const int count = oracleListClashes(hard->oracle, DOUBT, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListClashes(hard->oracle, DOUBT, count, expected.particles, expected.values, expected.margins);
    PairList list = compareLists(hard, "clashes", 0, listClashes, &expected);
    for (int engine = 0; engine < hard->engineCount; engine++) {
        bool clash = false;
        int pair[2] = {CT_NULL, CT_NULL};
        SUCCEED(hard, engine, ctHasClash(hard->engines[engine], &clash, pair, NULL));
        need(clash == (list.count > 0), hard, "ctHasClash says %d; %d pairs are listed", clash, list.count);
        need(!clash || findPair(&list, pair[0], pair[1]) != NULL, hard, "%d-%d is in no list", pair[0], pair[1]);
    }
    free(list.pairs);
    expectedDestroy(&expected);
}

/* ---- Numbers ---- */

/* The first half of all particles against the second, and every third against all. */
static void compareLeastDistances(HardCase* hard)
{
    const int count = hard->scene->particleCount;
    int* particles = allocate((size_t)count, sizeof(int));
    int* thirds = allocate((size_t)count, sizeof(int));
    for (int i = 0; i < count; i++) {
        particles[i] = i;
        thirds[i / 3] = i / 3 * 3;
    }
    const int half = count / 2, third = (count + 2) / 3;
    const struct {
        int counts[2];
        const int* sets[2];
    } questions[] = {{{half, count - half}, {particles, particles + half}}, {{third, count}, {thirds, particles}}};
    for (int q = 0; q < 2; q++) {
        const double expected = oracleMinimumDistance(hard->oracle, questions[q].counts[0], questions[q].sets[0],
                                                      questions[q].counts[1], questions[q].sets[1]);
        double first = 0;
        for (int engine = 0; engine < hard->engineCount; engine++) {
            ctChainTree* tree = hard->engines[engine];
            ctSelection* selections[2];
            double distance = INFINITY;
            int pair[2];
            for (int side = 0; side < 2; side++)
                SUCCEED(hard, engine,
                        ctSelect(tree, questions[q].counts[side], questions[q].sets[side], &selections[side]));
            const ctStatus status = ctGetMinimumDistance(tree, selections[0], selections[1], &distance, pair, NULL);
            ctFreeSelection(selections[0]);
            ctFreeSelection(selections[1]);
            need((status == ctSuccess) == isfinite(expected), hard, "least distance: status %d", (int)status);
            need(status != ctSuccess || fabs(distance - expected) <= hard->distanceError, hard,
                 "the least distance is %.17g by %s, not %.17g", distance, engineName(engine), expected);
            first = engine == 0 ? distance : first;
            need(distance == first, hard, "the least distance is %.17g by %s, %.17g by %s", distance,
                 engineName(engine), first, engineName(0));
        }
    }
    free(particles);
    free(thirds);
}

/* Forces of pairs that are all but coincident have a direction of rounding, so their sum of squares says nothing. */
static void compareEnergy(HardCase* hard)
{
    const double k = 2;
    const int count = oracleListClashes(hard->oracle, DOUBT, 0, NULL, NULL, NULL);
    Expected clashes = expectedCreate(count);
    oracleListClashes(hard->oracle, DOUBT, count, clashes.particles, clashes.values, clashes.margins);
    double* errors = allocate(coordinateCount(hard) / 3, sizeof(double));
    double energyError = 0;
    for (int e = 0; e < count; e++) {
        const int i = clashes.particles[2 * e], j = clashes.particles[2 * e + 1];
        const double distance = oracleDistance(hard->oracle, ORACLE_STATE, i, j), depth = fabs(clashes.margins[e]);
        const double depthError = hard->distanceError + (depth <= DOUBT ? DOUBT : 0);
        const double directionError = distance > 0 ? fmin(2, 4 * hard->distanceError / distance) : 2;
        errors[i] += k * (depthError + depth * directionError);
        errors[j] += k * (depthError + depth * directionError);
        energyError += k * (depth + depthError) * depthError;
    }
    expectedDestroy(&clashes);
    double* forces = allocate(coordinateCount(hard), sizeof(double));
    double* expectedForces = allocate(coordinateCount(hard), sizeof(double));
    const double expected = oracleEnergy(hard->oracle, k, expectedForces);
    double first = 0;
    for (int engine = 0; engine < hard->engineCount; engine++) {
        double energy = -1;
        memset(forces, 0, coordinateCount(hard) * sizeof(double));
        SUCCEED(hard, engine, ctComputeEnergy(hard->engines[engine], k, &energy, forces, NULL));
        first = engine == 0 ? energy : first;
        need(energy == first, hard, "the energy is %.17g by %s, %.17g by %s", energy, engineName(engine), first,
             engineName(0));
        need(fabs(energy - expected) <= energyError + 1e-13 * expected, hard, "the energy is %.17g, not %.17g", energy,
             expected);
        for (size_t n = 0; n < coordinateCount(hard); n++)
            need(fabs(forces[n] - expectedForces[n]) <= errors[n / 3] + 1e-12 * (1 + fabs(expectedForces[n])), hard,
                 "force component %zu of particle %zu is %.17g, not %.17g", n % 3, n / 3, forces[n], expectedForces[n]);
    }
    free(errors);
    free(forces);
    free(expectedForces);
}

void compareState(HardCase* hard, double cutoff)
{
    comparePositions(hard);
    compareClashes(hard);
    compareNeighbors(hard, cutoff);
    compareLeastDistances(hard);
    compareEnergy(hard);
    for (int engine = 0; engine < hard->engineCount; engine++)
        need(ctValidate(hard->engines[engine]), hard, "ctValidate, by %s", engineName(engine));
}

/* ---- Limits ---- */

void raiseLimits(HardCase* hard)
{
    int first = 0;
    for (int engine = 0; engine < hard->engineCount; engine++) {
        int raised = -1;
        SUCCEED(hard, engine, ctRaiseLimits(hard->engines[engine], &raised, NULL));
        first = engine == 0 ? raised : first;
        need(raised == first, hard, "%d limits raised by %s, %d by %s", raised, engineName(engine), first,
             engineName(0));
    }
    const int count = ctGetLimitCount(hard->engines[0]);
    int(*pairs)[2] = allocate((size_t)count, sizeof *pairs);
    double* limits = allocate((size_t)count, sizeof *limits);
    ctGetLimits(hard->engines[0], count, pairs, limits);
    oracleSetLimits(hard->oracle, count, *pairs, limits);
    free(pairs);
    free(limits);
}

/* ---- Wandering ---- */

void randomPoint(randomSource* random, double low, double high, double point[3])
{
    for (int axis = 0; axis < 3; axis++)
        point[axis] = randomReal(random, low, high);
}

static double chooseAngle(randomSource* random, double step)
{
    switch (randomInt(random, 8)) {
    case 0:
        return randomReal(random, -PI, PI);
    case 1:
        return randomChance(random, 0.5) ? PI : -PI;
    case 2:
        return 2 * PI * (randomInt(random, 5) - 2);
    default:
        return randomReal(random, -step, step);
    }
}

static ctChange chooseChange(const HardCase* hard, randomSource* random, int link, double step)
{
    ctChange change = {.link = link};
    if (hard->scene->linkJoints[link] == ctTorsionJoint) {
        change.angle = chooseAngle(random, step);
        return change;
    }
    int particle = 0;
    while (hard->scene->particleLinks[particle] != link)
        particle++;
    ctGetPositions(hard->engines[0], hard->positions);
    memcpy(change.pivot, hard->positions + 3 * particle, sizeof change.pivot);
    randomDirection(random, change.rotation);
    randomDirection(random, change.translation);
    const double angle = randomReal(random, 0, step), shift = randomReal(random, 0, step);
    for (int axis = 0; axis < 3; axis++) {
        change.rotation[axis] *= angle;
        change.translation[axis] *= shift;
    }
    return change;
}

void wander(HardCase* hard, randomSource* random, int trials, double step, double cutoff)
{
    compareState(hard, cutoff);
    for (int trial = 1; trial <= trials; trial++) {
        ctChange changes[3];
        int count = 0;
        for (int attempt = randomChance(random, 0.7) ? 2 : 0; attempt < 3; attempt++) {
            const int link = randomInt(random, hard->scene->linkCount);
            bool isNew = hard->scene->linkJoints[link] != ctFixedJoint;
            for (int n = 0; n < count; n++)
                isNew = isNew && changes[n].link != link;
            if (isNew)
                changes[count++] = chooseChange(hard, random, link, step);
        }
        const bool clash = tryChanges(hard, count, changes);
        if (trial % 8 == 0)
            compareChangedPairs(hard, cutoff);
        if (!clash || randomChance(random, 0.1))
            acceptTrial(hard);
        else
            dropTrial(hard);
        if (trial % (trials / 3 + 1) == 0)
            compareState(hard, cutoff);
    }
    compareState(hard, cutoff);
}
