/* Sizes and places far from those of atoms: radii over six orders, coordinates far from the origin and far from each
 * other, denormal numbers. */
#include "hardcase.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

/* ---- Radii ---- */

/* Free beads between 1e-4 and 1e2 nm, which overlap as they may. */
static void testSixOrders(void)
{
    randomSource random = randomSourceFromSeed(1);
    Scene scene = {.overlapTolerance = 1e-4};
    for (int i = 0; i < 200; i++) {
        double point[3];
        randomPoint(&random, -60, 60, point);
        addParticle(&scene, addFreeLink(&scene), point[0], point[1], point[2], pow(10, randomReal(&random, -4, 2)));
    }
    HardCase hard;
    openCase(&hard, "radii over six orders", &scene);
    raiseLimits(&hard);
    wander(&hard, &random, 100, 0.01, 20);
    wander(&hard, &random, 100, 20, 20);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "all verdicts are the same");
    closeCase(&hard);
    sceneFree(&scene);
}

/* A sphere of radius 1000 and, touching it, a chain of spheres a thousandth of its size; the sphere is an obstacle, a
 * separate molecule, or the chain's head. */
static void testHuge(int kind)
{
    enum { LINKS = 150 };
    static double points[LINKS][3];
    for (int i = 0; i < LINKS; i++) {
        const double angle = 3e-6 * i;
        points[i][0] = 1000.0011 * cos(angle);
        points[i][1] = 1000.0011 * sin(angle);
        points[i][2] = i % 2 == 0 ? 0 : 0.002;
    }
    Scene scene = {0};
    addChain(&scene, ctFreeJoint, LINKS, (const double(*)[3])points, 0.001, 2);
    addParticle(&scene, kind == 0 ? addFixedLink(&scene) : kind == 1 ? addFreeLink(&scene) : 0, 0, 0, 0, 1000);
    HardCase hard;
    openCase(&hard, "a huge sphere", &scene);
    randomSource random = randomSourceFromSeed(2);
    wander(&hard, &random, 60, 0.01, 0.005);
    wander(&hard, &random, 60, 1e-5, 1000.002);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "all verdicts are the same");
    closeCase(&hard);
    sceneFree(&scene);
}

/* ---- Places ---- */

enum { COIL = 180 };

/* Layers of circles; everything in it is `scale` times as large as with atoms. */
static void addCoil(Scene* scene, ctJointKind root, double x, double y, double z, double scale)
{
    static double points[COIL][3];
    for (int i = 0; i < COIL; i++) {
        const double angle = 0.3 * i;
        points[i][0] = x + scale * cos(angle);
        points[i][1] = y + scale * sin(angle);
        points[i][2] = z + scale * (0.015 * i + (i % 2 == 0 ? 0 : 0.1));
    }
    addChain(scene, root, COIL, (const double(*)[3])points, 0.13 * scale, 1);
}

static void testOffset(double x, double y, double z)
{
    Scene scene = {0};
    addCoil(&scene, ctFreeJoint, x, y, z, 1);
    char name[64];
    snprintf(name, sizeof name, "a coil at (%g, %g, %g)", x, y, z);
    HardCase hard;
    openCase(&hard, name, &scene);
    randomSource random = randomSourceFromSeed(3);
    wander(&hard, &random, 80, 0.1, 0.4);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "all verdicts are the same");
    closeCase(&hard);
    sceneFree(&scene);
}

/* Two coils so far apart that the rounding of their distance exceeds distances within a coil. */
static void testFarApart(double distance)
{
    Scene scene = {0};
    addCoil(&scene, ctFreeJoint, 0, 0, 0, 1);
    addCoil(&scene, ctFreeJoint, distance, -distance, 0.3, 1);
    HardCase hard;
    char name[64];
    snprintf(name, sizeof name, "two coils %g apart", distance);
    openCase(&hard, name, &scene);
    randomSource random = randomSourceFromSeed(4);
    wander(&hard, &random, 80, 0.1, 0.4);
    need(hard.clashing > 0 && hard.clashFree > 0, &hard, "all verdicts are the same");
    closeCase(&hard);
    sceneFree(&scene);
}

/* In one trial two beads of a small scene go far, where one number in float is a sixteenth of a nanometre from the
 * next, and meet there, or just do not. */
static void testFarTrip(void)
{
    randomSource random = randomSourceFromSeed(9);
    Scene scene = {0};
    for (int i = 0; i < 40; i++)
        addParticle(&scene, addFreeLink(&scene), 0.3 * (i % 6), 0.3 * (i / 6), 0, 0.1);
    HardCase hard;
    openCase(&hard, "a trip to far away", &scene);
    for (int trial = 0; trial < 200; trial++) {
        const int links[2] = {randomInt(&random, 20), 20 + randomInt(&random, 20)};
        double way[3], apart[3];
        randomDirection(&random, way);
        randomDirection(&random, apart);
        const double distance = 0.2 + randomReal(&random, -1e-3, 1e-3);
        ctChange changes[2];
        for (int n = 0; n < 2; n++) {
            const double* from = scene.positions + 3 * links[n];
            changes[n] = (ctChange){.link = links[n]};
            for (int axis = 0; axis < 3; axis++)
                changes[n].translation[axis] = 1e6 * way[axis] + n * distance * apart[axis] - from[axis];
        }
        tryChanges(&hard, 2, changes);
        compareChangedPairs(&hard, 0.2);
        dropTrial(&hard);
    }
    need(hard.clashing > 50 && hard.clashFree > 50, &hard, "%ld verdicts clash, %ld do not", hard.clashing,
         hard.clashFree);
    closeCase(&hard);
    sceneFree(&scene);
}

/* So small that most or all distances are within CT_SIGMA of a limit, where engines need only agree with each other. It
 * hangs on the world: the oracle would not know such coordinates apart if they were not about the origin. */
static void testSmall(double scale)
{
    Scene scene = {0};
    addCoil(&scene, ctFixedJoint, 0, 0, 0, scale);
    HardCase hard;
    char name[64];
    snprintf(name, sizeof name, "a coil of size %g", scale);
    openCase(&hard, name, &scene);
    randomSource random = randomSourceFromSeed(5);
    wander(&hard, &random, 60, 0.1, fmax(0.4 * scale, DBL_MIN));
    closeCase(&hard);
    sceneFree(&scene);
}

/* Here squares vanish in double, too, so a bond is no axis any more. */
static void testVanishing(double scale)
{
    Scene scene = {0};
    addCoil(&scene, ctFreeJoint, 0, 0, 0, scale);
    HardCase hard;
    char name[64];
    snprintf(name, sizeof name, "a coil of size %g", scale);
    openCase(&hard, name, &scene);
    compareState(&hard, scale);
    for (int engine = 0; engine < hard.engineCount; engine++) {
        const ctChange change = {.link = 20, .angle = 1};
        need(ctPropose(hard.engines[engine], 1, &change) == ctInvalidArgument, &hard, "it can turn");
    }
    tryShift(&hard, 0, 0.1, 0, 0);
    acceptTrial(&hard);
    compareState(&hard, scale);
    closeCase(&hard);
    sceneFree(&scene);
}

/* ---- Denormal numbers ---- */

/* Particles at denormal distances, with denormal radii and others, and turns by denormal angles. */
static void testDenormals(void)
{
    static const double numbers[] = {0x1p-1074, 3e-310, 1e-40, 1e-30, 1e-20};
    randomSource random = randomSourceFromSeed(7);
    Scene scene = {0};
    addCoil(&scene, ctFreeJoint, 0, 0, 0, 1);
    for (int i = 0; i < 60; i++) {
        const double tiny = numbers[randomInt(&random, 5)];
        const double radius = randomChance(&random, 0.5) ? numbers[randomInt(&random, 5)] : 0.05;
        addParticle(&scene, randomChance(&random, 0.5) ? addFreeLink(&scene) : COIL / 2, tiny, -2 * tiny, 0, radius);
    }
    HardCase hard;
    openCase(&hard, "denormal numbers", &scene);
    for (int i = 0; i < 5; i++) {
        tryTurn(&hard, COIL / 2, numbers[i]);
        compareChangedPairs(&hard, 0.3);
        acceptTrial(&hard);
        tryTurn(&hard, COIL / 3, -numbers[i]);
        dropTrial(&hard);
        compareState(&hard, 0.3);
        compareState(&hard, numbers[i]);
    }
    raiseLimits(&hard);
    wander(&hard, &random, 60, 0.1, 0.3);
    closeCase(&hard);
    sceneFree(&scene);
}

int main(void)
{
    testSixOrders();
    for (int kind = 0; kind < 3; kind++)
        testHuge(kind);
    testOffset(1e3, 1e3, 1e3);
    testOffset(-1e6, 1e6, 1e6);
    testOffset(1e6, 0, -1e3);
    testFarApart(1e3);
    testFarApart(1e6);
    testFarTrip();
    testSmall(1e-3);
    testSmall(1e-6);
    testSmall(1e-12);
    testSmall(1e-25);
    testVanishing(1e-300);
    testVanishing(1e-310);
    testDenormals();
    return 0;
}
