/* Particles without a radius that are listed in the definition: whatever is asked, the scene answers as the same one in
 * which they are not listed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chaintree.h"
#include "oracle/randomScene.h"
#include "sceneDefinition.h"

enum { SCENES = 250, TRIALS = 12, MOST_CHANGES = 3, MOST_PARTICLES = 700 };

static int failures;

#define EXPECT(condition)                                                                                              \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                     \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

/* Pairs that a query calls back with. */
typedef struct Pairs {
    int count, capacity;
    int (*pairs)[2];
    double sum; /* of values */
} Pairs;

static bool addPair(void* context, int particle1, int particle2, double value)
{
    Pairs* list = context;
    if (list->count == list->capacity) {
        list->capacity = 2 * list->capacity + 64;
        list->pairs = realloc(list->pairs, (size_t)list->capacity * sizeof *list->pairs);
        if (list->pairs == NULL)
            abort();
    }
    list->pairs[list->count][0] = particle1;
    list->pairs[list->count++][1] = particle2;
    list->sum += value;
    return true;
}

static bool addChanged(void* context, int particle1, int particle2, double before, double after)
{
    return addPair(context, particle1, particle2, before + 2 * after);
}

static bool addOverlap(void* context, int particle, double overlap)
{
    return addPair(context, particle, particle, overlap);
}

static int comparePairs(const void* a, const void* b)
{
    const int *x = a, *y = b;
    return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* Compares two lists and empties them. */
static void expectSame(Pairs lists[2])
{
    EXPECT(lists[0].count == lists[1].count);
    EXPECT(fabs(lists[0].sum - lists[1].sum) <= 1e-9 * (1 + fabs(lists[0].sum)));
    for (int k = 0; k < 2; k++)
        if (lists[k].count > 0)
            qsort(lists[k].pairs, (size_t)lists[k].count, sizeof *lists[k].pairs, comparePairs);
    if (lists[0].count == lists[1].count && lists[0].count > 0)
        EXPECT(memcmp(lists[0].pairs, lists[1].pairs, (size_t)lists[0].count * sizeof *lists[0].pairs) == 0);
    for (int k = 0; k < 2; k++)
        lists[k].count = 0, lists[k].sum = 0;
}

static ctChainTree* createTree(const randomScene* scene, const unsigned char* listed)
{
    const ctDefinition definition = defineScene(scene, listed);
    return createDefined(&definition);
}

/* Two scenes: without and with listed particles. */
typedef struct Twins {
    randomScene scene;
    randomSource random;
    ctChainTree* trees[2];
    double* numbers[2]; /* 3 a particle */
    Pairs lists[2];
    double tolerance;
} Twins;

static void expectNear(const Twins* t)
{
    for (int i = 0; i < 3 * t->scene.particleCount; i++)
        EXPECT(fabs(t->numbers[0][i] - t->numbers[1][i]) <= t->tolerance);
}

static void compareMinimumDistances(Twins* t)
{
    int counts[2], *particles[2];
    double distances[2] = {0};
    int pairs[2][2];
    ctStatus statuses[2];
    for (int n = 0; n < 2; n++) {
        counts[n] = 1 + randomInt(&t->random, t->scene.particleCount);
        particles[n] = calloc((size_t)counts[n], sizeof(int));
        for (int i = 0; i < counts[n]; i++)
            particles[n][i] = randomInt(&t->random, t->scene.particleCount);
    }
    for (int k = 0; k < 2; k++) {
        ctSelection* selections[2];
        for (int n = 0; n < 2; n++)
            EXPECT(ctSelect(t->trees[k], counts[n], particles[n], &selections[n]) == ctSuccess);
        statuses[k] = ctGetMinimumDistance(t->trees[k], selections[0], selections[1], &distances[k], pairs[k], NULL);
        ctFreeSelection(selections[0]);
        ctFreeSelection(selections[1]);
    }
    EXPECT(statuses[0] == statuses[1]);
    EXPECT(statuses[0] != ctSuccess || fabs(distances[0] - distances[1]) <= t->tolerance);
    free(particles[0]);
    free(particles[1]);
}

static void compareStates(Twins* t)
{
    bool clashes[2];
    int raised[2];
    double energies[2], centroids[2][3];
    double cutoff = randomReal(&t->random, 0.05, 0.6), radius = randomReal(&t->random, 0, 0.3);
    int probe = randomInt(&t->random, t->scene.particleCount);
    int link = t->scene.particleLinks[probe];
    ctStatus statuses[2];
    for (int k = 0; k < 2; k++) {
        ctGetPositions(t->trees[k], t->numbers[k]);
        EXPECT(ctHasClash(t->trees[k], &clashes[k], NULL, NULL) == ctSuccess);
        EXPECT(ctForEachClash(t->trees[k], addPair, &t->lists[k], NULL) == ctSuccess);
    }
    expectNear(t);
    EXPECT(clashes[0] == clashes[1]);
    expectSame(t->lists);
    for (int k = 0; k < 2; k++)
        EXPECT(ctForEachNeighborPair(t->trees[k], cutoff, addPair, &t->lists[k], NULL) == ctSuccess);
    expectSame(t->lists);
    double point[3];
    for (int d = 0; d < 3; d++)
        point[d] = t->numbers[0][3 * probe + d] + 0.05;
    for (int k = 0; k < 2; k++)
        EXPECT(ctForEachClashWith(t->trees[k], point, radius, addOverlap, &t->lists[k], NULL) == ctSuccess);
    expectSame(t->lists);
    for (int k = 0; k < 2; k++) {
        memset(t->numbers[k], 0, 3 * (size_t)t->scene.particleCount * sizeof(double));
        EXPECT(ctComputeEnergy(t->trees[k], 1, &energies[k], t->numbers[k], NULL) == ctSuccess);
        statuses[k] = ctGetCentroid(t->trees[k], link, centroids[k]);
        EXPECT(ctRaiseLimits(t->trees[k], &raised[k], NULL) == ctSuccess);
        EXPECT(ctValidate(t->trees[k]));
    }
    expectNear(t);
    EXPECT(fabs(energies[0] - energies[1]) <= 1e-9 * (1 + energies[0]));
    EXPECT(raised[0] == raised[1] && ctGetLimitCount(t->trees[0]) == ctGetLimitCount(t->trees[1]));
    EXPECT(statuses[0] == statuses[1]);
    for (int d = 0; d < 3 && statuses[0] == ctSuccess; d++)
        EXPECT(fabs(centroids[0][d] - centroids[1][d]) <= t->tolerance);
    compareMinimumDistances(t);
}

static int chooseChanges(Twins* t, ctChange* changes)
{
    int count = 0;
    for (int tries = 1 + randomInt(&t->random, MOST_CHANGES); tries > 0; tries--) {
        int link = randomInt(&t->random, t->scene.linkCount), isNew = t->scene.linkJoints[link] != ctFixedJoint;
        for (int i = 0; i < count; i++)
            isNew = isNew && changes[i].link != link;
        if (!isNew)
            continue;
        double size = randomChance(&t->random, 0.7) ? 0.05 : 2.0;
        ctChange change = {.link = link, .angle = randomReal(&t->random, -size, size)};
        for (int d = 0; d < 3; d++) {
            change.rotation[d] = randomReal(&t->random, -size, size);
            change.pivot[d] = t->scene.positions[d];
            change.translation[d] = randomReal(&t->random, -size, size);
        }
        changes[count++] = change;
    }
    return count;
}

/* Of any particles, whether they are listed or not. */
static int chooseDisplacements(Twins* t, ctDisplacement* displacements)
{
    int count = 0;
    for (int tries = 1 + randomInt(&t->random, MOST_CHANGES); tries > 0; tries--) {
        const int particle = randomInt(&t->random, t->scene.particleCount);
        int isNew = t->scene.linkJoints[t->scene.particleLinks[particle]] != ctFixedJoint;
        for (int i = 0; i < count; i++)
            isNew = isNew && displacements[i].particle != particle;
        if (!isNew)
            continue;
        displacements[count].particle = particle;
        for (int d = 0; d < 3; d++)
            displacements[count].shift[d] = randomReal(&t->random, -0.05, 0.05);
        count++;
    }
    return count;
}

static void runTrial(Twins* t)
{
    ctChange changes[MOST_CHANGES];
    ctDisplacement displacements[MOST_CHANGES];
    const int displaced =
        t->scene.isFlexible && randomChance(&t->random, 0.5) ? chooseDisplacements(t, displacements) : 0;
    int count = chooseChanges(t, changes), accepts = randomChance(&t->random, 0.5);
    double cutoff = randomReal(&t->random, 0.05, 0.5);
    bool clashes[2];
    for (int k = 0; k < 2; k++) {
        EXPECT((displaced > 0 ? ctProposeDisplacements(t->trees[k], displaced, displacements)
                              : ctPropose(t->trees[k], count, changes)) == ctSuccess);
        EXPECT(ctTestTrial(t->trees[k], &clashes[k], NULL, NULL) == ctSuccess);
        EXPECT(ctForEachChangedPair(t->trees[k], cutoff, addChanged, &t->lists[k], NULL) == ctSuccess);
        EXPECT(ctFollowTrialPositions(t->trees[k], false, t->numbers[k]) == ctSuccess);
    }
    EXPECT(clashes[0] == clashes[1]);
    expectSame(t->lists);
    for (int k = 0; k < 2; k++) {
        EXPECT(ctGetTrialPositions(t->trees[k], t->numbers[k]) == ctSuccess);
        if (accepts)
            EXPECT(ctAccept(t->trees[k], NULL) == ctSuccess);
    }
    expectNear(t);
}

static void runScene(int seed)
{
    Twins t = {.random = randomSourceFromSeed((uint64_t)seed)};
    randomSceneCreate(&t.scene, &t.random);
    if (t.scene.particleCount > MOST_PARTICLES) {
        randomSceneDestroy(&t.scene);
        return;
    }
    size_t coordinates = 3 * (size_t)t.scene.particleCount;
    /* Without exact ties, about which the two scenes, which are laid out differently, may disagree. */
    for (size_t i = 0; i < coordinates; i++)
        t.scene.positions[i] += randomReal(&t.random, -1e-3, 1e-3);
    unsigned char* listed = calloc((size_t)t.scene.particleCount, 1);
    double bare = randomReal(&t.random, 0, 1), chance = randomChance(&t.random, 0.5) ? 1 : 0.5;
    for (int i = 0; i < t.scene.particleCount; i++) {
        if (randomChance(&t.random, bare))
            t.scene.radii[i] = 0;
        listed[i] = (unsigned char)randomChance(&t.random, chance);
    }
    double size = t.scene.extent + 100;
    for (int d = 0; d < 3; d++)
        size += fabs(t.scene.positions[d]);
    t.tolerance = 1e-13 * size;
    for (int k = 0; k < 2; k++) {
        t.trees[k] = createTree(&t.scene, k == 0 ? NULL : listed);
        t.numbers[k] = calloc(coordinates + 1, sizeof(double));
    }
    for (int n = 0; n < TRIALS; n++) {
        runTrial(&t);
        if (n % 4 == 3)
            compareStates(&t);
    }
    for (int k = 0; k < 2; k++) {
        ctDestroy(t.trees[k]);
        free(t.numbers[k]);
        free(t.lists[k].pairs);
    }
    free(listed);
    randomSceneDestroy(&t.scene);
}

int main(void)
{
    for (int seed = 0; seed < SCENES && failures < 20; seed++) {
        int before = failures;
        runScene(seed);
        if (failures > before)
            printf("scene %d\n", seed);
    }
    return failures > 0;
}
