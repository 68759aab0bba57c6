/* Spheres whose gap or overlap is some units in the last place: all engines give the same answer, and a trial is
 * decided like the state that it leads to. */
#include "hardcase.h"

#include <math.h>
#include <stddef.h>

enum { ULPS = 3 };

static double shiftedBy(double value, int ulps)
{
    for (; ulps > 0; ulps--)
        value = nextafter(value, INFINITY);
    for (; ulps < 0; ulps++)
        value = nextafter(value, 0);
    return value;
}

static bool hasClash(const HardCase* hard)
{
    bool clash = false;
    need(ctHasClash(hard->engines[0], &clash, NULL, NULL) == ctSuccess, hard, "ctHasClash fails");
    return clash;
}

/* ---- Two beads ---- */

/* Among others that are far away; the second comes from elsewhere. Coordinates of few bits make distances exact. */
static void testBeads(const double apart[3], bool isExact)
{
    const double distance = sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
    for (int ulps = -ULPS; ulps <= ULPS; ulps++) {
        Scene scene = {0};
        for (int i = 0; i < 40; i++)
            addParticle(&scene, addFreeLink(&scene), 8 + 3 * i, 1, 2, 0.5);
        addParticle(&scene, addFreeLink(&scene), 0.25, 0.5, 0.75, 0.25);
        addParticle(&scene, addFreeLink(&scene), apart[0] - 1.75, apart[1] + 0.5, apart[2] + 0.75,
                    shiftedBy(distance, ulps) - 0.25);
        HardCase hard;
        openCase(&hard, "two beads", &scene);
        for (int i = -ULPS; i <= ULPS; i++) {
            tryShift(&hard, 41, shiftedBy(2, i), 0, 0);
            compareChangedPairs(&hard, shiftedBy(distance, i));
            dropTrial(&hard);
        }
        const bool clash = tryShift(&hard, 41, 2, 0, 0);
        need(!isExact || clash == (ulps > 0), &hard, "%d units beyond touching, the verdict is %d", ulps, clash);
        acceptTrial(&hard);
        need(hasClash(&hard) == clash, &hard, "a trial called %d leads to a state called %d", clash, !clash);
        for (int i = -ULPS; i <= ULPS; i++)
            compareState(&hard, shiftedBy(distance, i));
        closeCase(&hard);
        sceneFree(&scene);
    }
}

/* ---- A lattice ---- */

/* All neighbours touch. Whole steps lead from sites to sites; turns by pi do too, but for rounding. */
static void testLattice(int ulps)
{
    enum { SIDE = 7 };
    Scene scene = {0};
    const double radius = shiftedBy(0.25, ulps);
    for (int x = 0; x < SIDE; x++) {
        const int link = addFreeLink(&scene);
        for (int y = 0; y < SIDE; y++)
            for (int z = 0; z < SIDE; z++)
                addParticle(&scene, link, 0.5 * x, 0.5 * y, 0.5 * z, radius);
    }
    HardCase hard;
    openCase(&hard, "a lattice", &scene);
    need(hasClash(&hard) == (ulps > 0), &hard, "%d units beyond touching, it is called %d", ulps, hasClash(&hard));
    compareState(&hard, 0.5);
    for (int step = -2; step <= 2; step++) {
        const bool clash = tryShift(&hard, 3, 0, 0.5 * step, 0);
        need(clash == (ulps > 0), &hard, "shifted by %d sites, %d units beyond touching, it is called %d", step, ulps,
             clash);
        dropTrial(&hard);
    }
    const ctChange over = {.link = 3, .rotation = {acos(-1), 0, 0}, .pivot = {1.5, 1.5, 1.5}};
    const bool clash = tryChanges(&hard, 1, &over);
    compareChangedPairs(&hard, 0.5);
    acceptTrial(&hard);
    need(!clash || hasClash(&hard), &hard, "turned over it clashes, and then it does not");
    compareState(&hard, 0.5);
    closeCase(&hard);
    sceneFree(&scene);
}

/* ---- Chains ---- */

/* Turns that bring one sphere of a zigzag to where it touches another, found by bisection of the first engine's
 * verdicts: then all others change their minds at the same turn. */
static void testChain(int count, int link)
{
    Scene scene = {0};
    double points[64][3];
    for (int i = 0; i < count; i++) {
        points[i][0] = 0.3 * i;
        points[i][1] = i % 2 == 0 ? 0 : 0.3;
        points[i][2] = 0;
    }
    addChain(&scene, ctFreeJoint, count, (const double(*)[3])points, 0.22, 1);
    HardCase hard;
    openCase(&hard, "a zigzag", &scene);
    need(!tryTurn(&hard, link, 0), &hard, "it clashes unturned");
    need(tryTurn(&hard, link, acos(-1)), &hard, "it does not clash turned by pi");
    double free = 0, clashing = acos(-1);
    while (nextafter(free, clashing) < clashing) {
        const double middle = 0.5 * (free + clashing);
        if (tryTurn(&hard, link, middle))
            clashing = middle;
        else
            free = middle;
    }
    need(hard.doubtful > 10, &hard, "only %ld verdicts were within rounding", hard.doubtful);
    for (int ulps = -ULPS; ulps <= ULPS; ulps++) {
        const bool clash = tryTurn(&hard, link, shiftedBy(free, ulps));
        acceptTrial(&hard);
        need(hasClash(&hard) == clash, &hard, "a trial called %d leads to a state called %d", clash, !clash);
        compareState(&hard, 0.4);
        tryTurn(&hard, link, -shiftedBy(free, ulps));
        acceptTrial(&hard);
    }
    closeCase(&hard);
    sceneFree(&scene);
}

int main(void)
{
    static const struct {
        double apart[3];
        bool isExact;
    } beads[] = {{{1, 0, 0}, true}, {{0.75, 1, 0}, true}, {{1, 1, 1}, false}, {{0.1, 0.7, -0.3}, false}};
    for (size_t i = 0; i < sizeof beads / sizeof beads[0]; i++)
        testBeads(beads[i].apart, beads[i].isExact);
    for (int ulps = -ULPS; ulps <= ULPS; ulps++)
        testLattice(ulps);
    for (int link = 8; link <= 48; link += 8)
        testChain(60, link);
    return 0;
}
