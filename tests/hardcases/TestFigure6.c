/* The chain of the paper's figure 6 (section 4): all convex hulls of its units meet at one point, so no hierarchy of
 * convex volumes parts them. */
#include "hardcase.h"

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
static void testChain(int d, int trials)
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
    Scene scene = {0};
    addChain(&scene, ctFreeJoint, count, (const double(*)[3])points, RADIUS, 0);
    free(points);
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

int main(void)
{
    testChain(16, 100);
    testChain(24, 60);
    testChain(32, 40);
    return 0;
}
