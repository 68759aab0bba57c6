/* The chain of the paper's figure 6 (section 4): all convex hulls of its units meet at one point, so no hierarchy of
 * convex volumes parts them. */
#define _POSIX_C_SOURCE 200809L /* setenv */
#include "hardcase.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Spheres are 2 apart and touch but for this. */
#define RADIUS 0.999

/* Rows of d along x, y and z, each beginning beside the end of the one before. */
static void unitSite(int index, int d, int* site)
{
    const int row = index / d, step = index % d;
    site[0] = row == 0 ? step : d - 1;
    site[1] = row == 0 ? 0 : row == 1 ? 1 + step : d;
    site[2] = row < 2 ? 0 : 1 + step;
}

/* Unit vectors at right angles to each other, none of them near an axis of the world. */
static const double askewAxes[3][3] = {
    {2.0 / 7, 3.0 / 7, 6.0 / 7}, {3.0 / 7, -6.0 / 7, 2.0 / 7}, {6.0 / 7, 2.0 / 7, -3.0 / 7}};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* d / 8 units side by side make a layer, d / 8 layers the chain; every second unit and layer is walked backwards. */
static int addWorstCase(Scene* scene, int d, bool askew)
{
    const int unit = 3 * d, copies = d / 8, layer = unit * copies, count = layer * copies;
    double(*points)[3] = calloc((size_t)count, sizeof *points);
    if (points == NULL)
        abort();
    for (int i = 0; i < count; i++) {
        const int height = i / layer;
        const int inLayer = height % 2 == 0 ? i % layer : layer - 1 - i % layer;
        const int copy = inLayer / unit;
        int site[3];
        unitSite(copy % 2 == 0 ? inLayer % unit : unit - 1 - inLayer % unit, d, site);
        const double along[3] = {2 * (site[0] + copy), 2 * (site[1] - copy - height), 2 * (site[2] + height)};
        for (int k = 0; k < 3; k++)
            points[i][k] = askew ? dot(askewAxes[k], along) : along[k];
    }
    addChain(scene, ctFreeJoint, count, (const double(*)[3])points, RADIUS, 0);
    free(points);
    return count;
}

static void testChain(int d, bool askew, int trials)
{
    Scene scene = {0};
    const int count = addWorstCase(&scene, d, askew);
    char name[64];
    snprintf(name, sizeof name, "figure 6%s with d = %d, %d links", askew ? " askew" : "", d, count);
    HardCase hard;
    openCase(&hard, name, &scene);
    randomSource random = randomSourceFromSeed((uint64_t)d);
    wander(&hard, &random, trials, 1e-3, 2.5);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "%ld verdicts clash, %ld do not", hard.clashing,
         hard.clashFree);
    closeCase(&hard);
    sceneFree(&scene);
}

/* ---- How much is compared ---- */

static ctCounts costOfAll(const Scene* scene, const char* instructions)
{
    ctChainTree* tree = NULL;
    ctCounts cost = {0};
    bool clash = true;
    const ctDefinition definition = sceneDefinition(scene);
    if (setenv("CHAINTREE_SIMD", instructions, 1) != 0 || ctCreate(&definition, &tree, NULL, 0) != ctSuccess ||
        ctHasClash(tree, &clash, NULL, &cost) != ctSuccess)
        abort();
    ctDestroy(tree);
    if (clash) {
        printf("%d links clash\n", scene->linkCount);
        exit(1);
    }
    return cost;
}

/* Section 4: volumes no more than in proportion to N^(4/3), particles to N. */
static void testCost(int d, bool askew, double mostVolumes, int mostParticles)
{
    Scene scene = {0};
    const int count = addWorstCase(&scene, d, askew);
    const ctCounts cost = costOfAll(&scene, "portable");
    const ctCounts others[] = {costOfAll(&scene, "avx2"), costOfAll(&scene, "avx512")};
    const double scaled = (double)cost.volumeTests / pow(count, 4.0 / 3);
    for (int i = 0; i < 2; i++)
        if (others[i].volumeTests != cost.volumeTests || others[i].particleTests != cost.particleTests) {
            printf("%d links do not cost the same on all instruction sets\n", count);
            exit(1);
        }
    if (scaled > mostVolumes || cost.particleTests > (int64_t)mostParticles * count) {
        printf("%d links cost %.3f N^(4/3) tests of volumes and %.1f N of particles\n", count, scaled,
               (double)cost.particleTests / count);
        exit(1);
    }
    sceneFree(&scene);
}

int main(void)
{
    /* The second for boxes along the world's axes, which are wide where the rows are not along those. */
    for (int d = 24; d <= 72; d += 8) {
        testCost(d, false, 0.21, 12);
        testCost(d, true, 3, 220);
    }
    testChain(16, false, 100);
    testChain(16, true, 100);
    testChain(24, false, 60);
    testChain(32, false, 40);
    return 0;
}
