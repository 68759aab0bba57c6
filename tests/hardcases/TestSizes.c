/* Chains whose links just fill a leaf, a node or a level of the tree, or just do not.
 *
 * Usage: TestSizes [trials of a chain].
 */
#include "hardcase.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Rows to and fro, layer upon layer, a little out of line; so that many turns clash. */
static void place(int index, int side, randomSource* random, double* point)
{
    const int row = index / side, layer = row / side, x = index % side, y = row % side;
    const int site[3] = {row % 2 == 0 ? x : side - 1 - x, layer % 2 == 0 ? y : side - 1 - y, layer};
    for (int axis = 0; axis < 3; axis++)
        point[axis] = 0.38 * site[axis] + randomReal(random, -0.01, 0.01);
}

static void testSize(int count, ctJointKind root, int trials)
{
    randomSource random = randomSourceFromSeed((uint64_t)count);
    const int side = (int)ceil(cbrt(count));
    double(*points)[3] = calloc((size_t)count, sizeof *points);
    if (points == NULL)
        abort();
    for (int i = 0; i < count; i++)
        place(i, side, &random, points[i]);
    Scene scene = {.overlapTolerance = 0.01};
    addChain(&scene, root, count, (const double(*)[3])points, 0.17, 1);
    free(points);
    char name[64];
    snprintf(name, sizeof name, "a chain of %d links", count);
    HardCase hard;
    openCase(&hard, name, &scene);
    wander(&hard, &random, trials, fmin(0.3, 0.5 / (side * side)), 0.5);
    need(count < 30 || trials < 9 || (hard.clashing > 0 && hard.clashFree > 0), &hard, "%ld verdicts clash, %ld do not",
         hard.clashing, hard.clashFree);
    closeCase(&hard);
    sceneFree(&scene);
}

/* Several leaves and nodes of the tree hold no particle that counts. */
static void testBareMiddle(void)
{
    enum { LINKS = 900 };
    static double points[LINKS][3];
    randomSource random = randomSourceFromSeed(10);
    for (int i = 0; i < LINKS; i++)
        place(i, 10, &random, points[i]);
    Scene scene = {.overlapTolerance = 0.01};
    addChain(&scene, ctFreeJoint, LINKS, (const double(*)[3])points, 0.17, 1);
    for (int i = 230; i < 800; i++)
        scene.radii[i] = 0;
    HardCase hard;
    openCase(&hard, "a chain that counts at its ends", &scene);
    for (int link = 220; link < 820; link += 30) {
        tryTurn(&hard, link, 0.01);
        compareChangedPairs(&hard, 0.6);
        acceptTrial(&hard);
    }
    wander(&hard, &random, 60, 0.01, 0.6);
    closeCase(&hard);
    sceneFree(&scene);
}

int main(int argumentCount, char** arguments)
{
    const int trials = argumentCount > 1 ? atoi(arguments[1]) : 60;
    static const int small[] = {1, 2, 3, 4, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65};
    static const int large[] = {127, 128, 129, 240, 255, 256, 257, 272, 511, 512, 513};
    static const int largest[] = {4095, 4096, 4097};
    for (size_t i = 0; i < sizeof small / sizeof small[0]; i++) {
        testSize(small[i], ctFreeJoint, trials);
        testSize(small[i], ctFixedJoint, trials);
    }
    for (size_t i = 0; i < sizeof large / sizeof large[0]; i++)
        testSize(large[i], i % 2 == 0 ? ctFreeJoint : ctFixedJoint, trials);
    for (size_t i = 0; i < sizeof largest / sizeof largest[0]; i++)
        testSize(largest[i], ctFreeJoint, trials * 3 / 20);
    testBareMiddle();
    return 0;
}
