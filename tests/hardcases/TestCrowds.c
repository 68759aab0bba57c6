/* Too many pairs, too many molecules, all at one place. */
#include "hardcase.h"

#include <math.h>

static void addCrowdedChain(Scene* scene, randomSource* random, int count, double side, double radius)
{
    double points[400][3];
    for (int i = 0; i < count; i++)
        randomPoint(random, 0, side, points[i]);
    addChain(scene, ctFreeJoint, count, (const double(*)[3])points, radius, 1);
}

/* Everything overlaps and nothing clashes. */
static void testAllExcluded(void)
{
    randomSource random = randomSourceFromSeed(1);
    Scene scene = {0};
    addCrowdedChain(&scene, &random, 90, 1, 0.5);
    for (int i = 0; i < 90; i++)
        for (int j = 0; j < i; j++)
            addExclusion(&scene, (i + j) % 2 == 0 ? i : j, (i + j) % 2 == 0 ? j : i);
    HardCase hard;
    openCase(&hard, "all pairs excluded", &scene);
    wander(&hard, &random, 60, 1, 2);
    need(hard.clashing == 0, &hard, "%ld verdicts clash", hard.clashing);
    closeCase(&hard);
    sceneFree(&scene);
}

/* All but one pair, which is the last of many. */
static void testAllButOne(void)
{
    enum { COUNT = 60 };
    randomSource random = randomSourceFromSeed(2);
    Scene scene = {0};
    for (int i = 0; i < COUNT; i++) {
        double point[3];
        randomPoint(&random, 0, 1, point);
        addParticle(&scene, addFreeLink(&scene), point[0], point[1], 0, 2);
    }
    for (int i = 0; i < COUNT; i++)
        for (int j = 0; j < i; j++)
            if (i != COUNT - 1 || j != COUNT / 2)
                addExclusion(&scene, i, j);
    HardCase hard;
    openCase(&hard, "all pairs but one excluded", &scene);
    need(!tryShift(&hard, 3, 0.1, 0, 0), &hard, "an excluded pair clashes");
    need(tryShift(&hard, COUNT / 2, 0.1, 0, 0), &hard, "the one pair does not clash");
    compareChangedPairs(&hard, 5);
    need(!tryShift(&hard, COUNT - 1, 0, 0, 5), &hard, "the one pair clashes still");
    acceptTrial(&hard);
    compareState(&hard, 6);
    closeCase(&hard);
    sceneFree(&scene);
}

static void testManyMolecules(void)
{
    randomSource random = randomSourceFromSeed(3);
    Scene scene = {.overlapTolerance = 0.02};
    for (int i = 0; i < 4500; i++) {
        const int link = i % 3 == 0 ? addFixedLink(&scene) : addFreeLink(&scene);
        double point[3];
        randomPoint(&random, 0, 0.1, point);
        addParticle(&scene, link, point[0] + 0.4 * (i % 17), point[1] + 0.4 * (i / 17 % 17), point[2] + 0.4 * (i / 289),
                    0.14);
    }
    HardCase hard;
    openCase(&hard, "4,500 molecules of one particle", &scene);
    wander(&hard, &random, 24, 0.3, 0.5);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "%ld verdicts clash, %ld do not", hard.clashing,
         hard.clashFree);
    closeCase(&hard);
    sceneFree(&scene);
}

/* Every pair overlaps; with limits of their own some trials are free of clashes all the same. */
static void testDenseCloud(void)
{
    randomSource random = randomSourceFromSeed(4);
    Scene scene = {.overlapTolerance = 0.04};
    addCrowdedChain(&scene, &random, 200, 1, 1);
    for (int i = 0; i < 100; i++) {
        double point[3];
        randomPoint(&random, 0, 1, point);
        addParticle(&scene, i % 10 == 0 ? addFreeLink(&scene) : scene.linkCount - 1, point[0], point[1], point[2], 1);
    }
    HardCase hard;
    openCase(&hard, "a dense cloud", &scene);
    need(tryTurn(&hard, 100, 0.01), &hard, "a turn within a dense cloud is free of clashes");
    dropTrial(&hard);
    raiseLimits(&hard);
    need(!tryTurn(&hard, 100, 0), &hard, "a pair is beyond the limit that it was given");
    wander(&hard, &random, 40, 0.01, 0.3);
    raiseLimits(&hard);
    wander(&hard, &random, 20, 1e-10, 0.3);
    closeCase(&hard);
    sceneFree(&scene);
}

/* All at one place, or at one of two. */
static void testCoincident(double apart)
{
    randomSource random = randomSourceFromSeed(5);
    Scene scene = {0};
    for (int i = 0; i < 60; i++)
        addParticle(&scene, i % 4 == 0 ? addFreeLink(&scene) : scene.linkCount - 1, 0.3 + (i % 2) * apart, 0.2, 0.1,
                    0.1);
    /* A bond of length 0 has no axis, so these links are free or fixed. */
    addParticle(&scene, addFixedLink(&scene), 0.3, 0.2, 0.1, 0.1);
    HardCase hard;
    openCase(&hard, "coincident particles", &scene);
    wander(&hard, &random, 40, 0.2, 0.1);
    raiseLimits(&hard);
    wander(&hard, &random, 40, 0.2, 0.1);
    closeCase(&hard);
    sceneFree(&scene);
}

int main(void)
{
    testAllExcluded();
    testAllButOne();
    testManyMolecules();
    testDenseCloud();
    testCoincident(0);
    testCoincident(0.2);
    testCoincident(1e-17);
    return 0;
}
