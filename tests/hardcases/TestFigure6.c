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

/* d / 8 units side by side make a layer, d / 8 layers the chain; every second unit and layer is walked backwards. */
static int addWorstCase(Scene* scene, int d)
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
        points[i][0] = 2 * (site[0] + copy);
        points[i][1] = 2 * (site[1] - copy - height);
        points[i][2] = 2 * (site[2] + height);
    }
    addChain(scene, ctFreeJoint, count, (const double(*)[3])points, RADIUS, 0);
    free(points);
    return count;
}

static void testChain(int d, int trials)
{
    Scene scene = {0};
    const int count = addWorstCase(&scene, d);
    char name[64];
    snprintf(name, sizeof name, "figure 6 with d = %d, %d links", d, count);
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

/* Section 4: no more than in proportion to N^(4/3) volumes, and about as many particles as there are. */
static void testCost(int d)
{
    Scene scene = {0};
    const int count = addWorstCase(&scene, d);
    const ctCounts cost = costOfAll(&scene, "portable");
    const ctCounts others[] = {costOfAll(&scene, "avx2"), costOfAll(&scene, "avx512")};
    const double scaled = (double)cost.volumeTests / pow(count, 4.0 / 3);
    for (int i = 0; i < 2; i++)
        if (others[i].volumeTests != cost.volumeTests || others[i].particleTests != cost.particleTests) {
            printf("%d links do not cost the same on all instruction sets\n", count);
            exit(1);
        }
    if (scaled > 0.21 || cost.particleTests > 12 * count) {
        printf("%d links cost %.3f N^(4/3) tests of volumes and %.1f N of particles\n", count, scaled,
               (double)cost.particleTests / count);
        exit(1);
    }
    sceneFree(&scene);
}

int main(void)
{
    for (int d = 24; d <= 72; d += 8)
        testCost(d);
    testChain(16, 100);
    testChain(24, 60);
    testChain(32, 40);
    return 0;
}
