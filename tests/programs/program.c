#define _POSIX_C_SOURCE 200809L /* setenv */

#include "program.h"
#include "sceneDefinition.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Failure ---- */

void require(bool condition, const Program* p, const char* format, ...)
{
    if (condition)
        return;
    va_list arguments;
    va_start(arguments, format);
    printf("%s, step %d, %s: ", p->name, p->step, p->operation);
    vprintf(format, arguments);
    printf("\n(%d particles, %d links, %d movable)\n", p->scene.particleCount, p->scene.linkCount, p->movableCount);
    va_end(arguments);
    exit(1);
}

void requireStatus(const Program* p, const char* call, ctStatus status, ctStatus expected)
{
    require(status == expected, p, "%s returned %d, not %d: %s", call, (int)status, (int)expected,
            ctGetErrorText(p->tree));
    require(expected == ctSuccess || ctGetErrorText(p->tree)[0] != '\0', p, "%s failed without a text", call);
}

void requireNear(const Program* p, const char* what, int index, double value, double expected, double error)
{
    require(fabs(value - expected) <= error, p, "%s %d is %.17g, not %.17g", what, index, value, expected);
}

/* ---- Life ---- */

void* programAllocate(int count, size_t size)
{
    void* memory = calloc(count > 0 ? (size_t)count : 1, size);
    if (memory == NULL)
        abort();
    return memory;
}

void freeSet(KeptSet* set)
{
    ctFreeSelection(set->selection);
    free(set->particles);
    *set = (KeptSet){0};
}

double numberTolerance(const Program* p)
{
    const double factor = p->scene.isFlexible ? 5 : 1; /* turns about the places of particles are rounded, too */
    return factor * (1e-10 + 1e-12 * p->scene.extent);
}

int coordinateCount(const Program* p)
{
    return 3 * p->scene.particleCount;
}

size_t positionBytes(const Program* p)
{
    return (size_t)coordinateCount(p) * sizeof(double);
}

ctDefinition programDefinition(const Program* p)
{
    ctDefinition definition = defineScene(&p->scene, p->listed);
    definition.positions = p->firstPositions;
    return definition;
}

static void choosePath(Program* p)
{
    static const char* const instructionSets[] = {"avx512", "avx2", "portable"};
    static const char* const waysToTest[] = {"tree", "boxes", "clearances"};
    setenv("CHAINTREE_SIMD", instructionSets[randomInt(&p->random, 3)], 1);
    const int way = randomInt(&p->random, 4);
    if (way < 3)
        setenv("CHAINTREE_TRIALS", waysToTest[way], 1);
    else
        unsetenv("CHAINTREE_TRIALS");
}

ctChainTree* programCreateTree(Program* p)
{
    if (p->takesAnyPath)
        choosePath(p);
    const ctDefinition definition = programDefinition(p);
    ctChainTree* tree;
    char text[256] = "";
    ctStatus status = ctCreate(&definition, &tree, text, sizeof text);
    require(status == ctSuccess, p, "ctCreate returned %d: %s", (int)status, text);
    return tree;
}

oracleScene* createOracle(const ctDefinition* d)
{
    oracleScene* oracle =
        oracleCreate(d->particleCount, d->positions, d->radii, d->hydrogenBondRoles, d->particleLinks, d->linkCount,
                     d->linkParents, d->linkJoints, (const int*)d->linkTorsions, d->exclusionCount,
                     (const int*)d->exclusions, d->overlapTolerance, d->hydrogenBondAllowance);
    if (d->isFlexible)
        oracleMakeFlexible(oracle);
    return oracle;
}

/* Lists no particles, all, every second or some. Takes no choice: corpora and seeds keep their meaning. */
static void chooseListed(Program* p)
{
    const int kind = (p->scene.particleCount + p->scene.linkCount) % 4;
    if (kind == 0)
        return;
    p->listed = programAllocate(p->scene.particleCount, 1);
    for (int i = 0; i < p->scene.particleCount; i++)
        p->listed[i] = kind == 1 || (kind == 2 ? i % 2 == 0 : (unsigned)i * 2654435761u >> 29 < 5);
}

static void createBoth(Program* p)
{
    chooseListed(p);
    p->firstPositions = programAllocate(coordinateCount(p), sizeof(double));
    memcpy(p->firstPositions, p->scene.positions, positionBytes(p));
    p->tree = programCreateTree(p);
    const ctDefinition definition = programDefinition(p);
    p->oracle = createOracle(&definition);
    if (definition.isFlexible)
        p->isDisplaced = programAllocate(p->scene.particleCount, sizeof(bool));
}

static void listLinks(Program* p)
{
    int count = p->scene.linkCount;
    p->movable = programAllocate(count, sizeof(int));
    p->roots = programAllocate(count, sizeof(int));
    p->hasMoved = programAllocate(count, sizeof(bool));
    p->isInTrial = programAllocate(count, sizeof(bool));
    for (int link = 0; link < count; link++) {
        if (p->scene.linkJoints[link] != ctFixedJoint)
            p->movable[p->movableCount++] = link;
        for (int at = link; at != CT_NULL; at = p->scene.linkParents[at])
            p->roots[link] = at;
    }
}

void programCreate(Program* p, const char* name, randomScene scene, randomSource random, bool takesAnyPath,
                   Tally* tally)
{
    *p = (Program){.name = name,
                   .operation = "create",
                   .tally = tally,
                   .random = random,
                   .scene = scene,
                   .takesAnyPath = takesAnyPath};
    createBoth(p);
    listLinks(p);
    p->state = programAllocate(coordinateCount(p), sizeof(double));
    p->trial = programAllocate(coordinateCount(p), sizeof(double));
    p->followed = programAllocate(coordinateCount(p), sizeof(double));
    p->scratch = programAllocate(coordinateCount(p), sizeof(double));
    memcpy(p->state, p->scene.positions, positionBytes(p));
    requireUntouchedState(p);
    require(ctValidate(p->tree), p, "ctValidate");
    tally->programs++;
    tally->largest = p->scene.particleCount > tally->largest ? p->scene.particleCount : tally->largest;
}

void programDestroy(Program* p)
{
    ctDestroy(p->tree);
    oracleDestroy(p->oracle);
    randomSceneDestroy(&p->scene);
    free(p->firstPositions);
    free(p->listed);
    free(p->movable);
    free(p->roots);
    free(p->hasMoved);
    free(p->isInTrial);
    free(p->isDisplaced);
    free(p->state);
    free(p->trial);
    free(p->followed);
    free(p->scratch);
    free(p->limits.pairs);
    freeSet(&p->kept);
}

/* ---- What most operations check or choose ---- */

bool hasParticleMoved(const Program* p, int particle)
{
    return p->hasMoved[p->roots[p->scene.particleLinks[particle]]];
}

void requireSameBits(const Program* p, const char* what, const double* values, const double* expected)
{
    for (int n = 0; n < coordinateCount(p); n++)
        require(memcmp(values + n, expected + n, sizeof(double)) == 0, p,
                "%s: coordinate %d of particle %d is %.17g, not %.17g", what, n % 3, n / 3, values[n], expected[n]);
}

void requireUntouchedState(Program* p)
{
    ctGetPositions(p->tree, p->scratch);
    requireSameBits(p, "the state has changed", p->scratch, p->state);
    require(ctHasTrial(p->tree) == p->hasTrial, p, "a trial is %s", p->hasTrial ? "gone" : "open");
}

void requireOraclePositions(Program* p, int which, const double* positions)
{
    oracleGetPositions(p->oracle, which, p->scratch);
    for (int n = 0; n < coordinateCount(p); n++)
        requireNear(p, "coordinate", n, positions[n], p->scratch[n], numberTolerance(p));
}

ctCounts* chooseCounts(Program* p, ctCounts* counts)
{
    *counts = (ctCounts){5, 6, 7};
    return randomChance(&p->random, 0.5) ? counts : NULL;
}

void requireCounted(const Program* p, const ctCounts* counts)
{
    require(counts->volumeTests >= 5 && counts->particleTests >= 6 && counts->nodesUpdated >= 7, p,
            "counts were not added to");
}

double chooseCutoff(Program* p)
{
    double kind = randomReal(&p->random, 0, 1);
    if (kind < 0.1)
        return 0.2; /* the spacing of lattices */
    if (kind < 0.15)
        return 1e-3;
    if (kind < 0.16 && p->scene.particleCount < 200)
        return pow(10, randomReal(&p->random, 1, 300)); /* all pairs */
    return kind < 0.2 ? randomReal(&p->random, 1, 5) : randomReal(&p->random, 0.05, 0.6);
}

int chooseParticle(Program* p)
{
    return randomInt(&p->random, p->scene.particleCount);
}

double chooseNoLength(Program* p)
{
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e17, -1e300};
    return bad[randomInt(&p->random, 5)];
}

/* ---- Lists ---- */

Expected expectedCreate(int capacity)
{
    return (Expected){capacity, programAllocate(2 * capacity, sizeof(int)), programAllocate(capacity, sizeof(double)),
                      programAllocate(capacity, sizeof(double)), programAllocate(capacity, sizeof(double))};
}

void expectedDestroy(Expected* expected)
{
    free(expected->particles);
    free(expected->values);
    free(expected->others);
    free(expected->margins);
}

Expected expectedClashes(const Program* p)
{
    int count = oracleListClashes(p->oracle, DOUBT, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListClashes(p->oracle, DOUBT, count, expected.particles, expected.values, expected.margins);
    return expected;
}

void sortCollected(const Program* p, PairList* list)
{
    const Pair* twice = sortPairs(list);
    require(twice == NULL, p, "%d-%d comes twice", twice != NULL ? twice->particles[0] : 0,
            twice != NULL ? twice->particles[1] : 0);
}

void requireSameList(const Program* p, PairList* list, const Expected* expected, int valueCount)
{
    sortCollected(p, list);
    int n = 0;
    for (int e = 0; e < expected->count; e++) {
        const int* pair = expected->particles + 2 * e;
        bool isListed = n < list->count && memcmp(list->pairs[n].particles, pair, sizeof(int[2])) == 0;
        require(isListed || expected->margins[e] <= DOUBT, p, "%d-%d is missing; it is %g beyond the limit", pair[0],
                pair[1], expected->margins[e]);
        if (!isListed)
            continue;
        requireNear(p, "value of entry", n, list->pairs[n].values[0], expected->values[e], numberTolerance(p));
        if (valueCount == 2)
            requireNear(p, "second value of entry", n, list->pairs[n].values[1], expected->others[e],
                        numberTolerance(p));
        n++;
    }
    require(n == list->count, p, "%d-%d is listed and should not be", n < list->count ? list->pairs[n].particles[0] : 0,
            n < list->count ? list->pairs[n].particles[1] : 0);
}
