/* Turns and dihedrals by pi, whole turns, however many, and bonds that lie on a line. */
#include "hardcase.h"

#include <float.h>
#include <math.h>

#define PI 3.14159265358979323846

enum { LINKS = 70 };

/* A planar zigzag, or with `folds` a way to and fro; bonds are off the line by `bend`. All dihedrals are pi. */
static void addPlanarChain(Scene* scene, double bend, bool folds, double radius)
{
    static double points[LINKS][3];
    for (int i = 0; i < LINKS; i++) {
        points[i][0] = folds && i % 2 == 1 ? 0.5 : 0.5 * (folds ? 0 : i);
        points[i][1] = (i % 4 == 1 || i % 4 == 2 ? 0.5 : 0) * bend + (folds ? 0.5 * bend * i : 0);
        points[i][2] = 0;
    }
    addChain(scene, ctFreeJoint, LINKS, (const double(*)[3])points, radius, 2);
    /* Of the particles that a torsion is measured by, the outer two are its neighbours on the chain. */
    for (int link = 2; link < LINKS - 1; link++) {
        const int torsion[4] = {link - 2, link - 1, link, link + 1};
        for (int k = 0; k < 4; k++)
            scene->linkTorsions[link][k] = torsion[k];
    }
}

/* The engines' dihedrals against the oracle's; undefined ones are errors. */
static void compareDihedrals(HardCase* hard)
{
    for (int link = 2; link < LINKS - 1; link++) {
        double sine, expected = oracleTorsionAngle(hard->oracle, link, &sine);
        double first = 0;
        for (int engine = 0; engine < hard->engineCount; engine++) {
            double angle = 100;
            const ctStatus status = ctGetTorsionAngle(hard->engines[engine], link, &angle);
            need(status == ctSuccess || sine < 1.1e-8, hard, "no dihedral at link %d, whose sine is %g", link, sine);
            need(status == ctInvalidArgument || sine > 0.9e-8, hard, "a dihedral at link %d, whose sine is %g", link,
                 sine);
            if (status != ctSuccess)
                continue;
            need(angle > -PI && angle <= PI, hard, "the dihedral of link %d is %.17g", link, angle);
            need(fabs(remainder(angle - expected, 2 * PI)) <= 1e-13 + 1e-15 / sine, hard,
                 "the dihedral of link %d is %.17g, not %.17g", link, angle, expected);
            first = engine == 0 ? angle : first;
            need(angle == first, hard, "the dihedral of link %d is %.17g, then %.17g", link, angle, first);
        }
    }
}

static void testBend(const char* name, double bend, bool folds, double radius)
{
    Scene scene = {0};
    addPlanarChain(&scene, bend, folds, radius);
    HardCase hard;
    openCase(&hard, name, &scene);
    raiseLimits(&hard);
    compareDihedrals(&hard);
    randomSource random = randomSourceFromSeed(8);
    wander(&hard, &random, 60, 0.3, 0.6);
    compareDihedrals(&hard);
    closeCase(&hard);
    sceneFree(&scene);
}

/* ---- Whole and half turns ---- */

static void turnForGood(HardCase* hard, int link, double angle)
{
    tryTurn(hard, link, angle);
    acceptTrial(hard);
}

static void testTurns(void)
{
    static const double turns[] = {PI, -PI, 2 * PI, -2 * PI, 6 * PI, 2e3 * PI, 2e6 * PI, -2e9 * PI, 1e15, DBL_MAX};
    Scene scene = {0};
    addPlanarChain(&scene, 0.7, false, 0.05);
    HardCase hard;
    openCase(&hard, "whole turns", &scene);
    for (size_t i = 0; i < sizeof turns / sizeof turns[0]; i++) {
        const int link = 10 + 5 * (int)i;
        const double turn = turns[i];
        /* There and back is the state that it was, in every bit, since the angle is kept and not the matrix. */
        double before[3 * LINKS], after[3 * LINKS];
        ctGetPositions(hard.engines[0], before);
        turnForGood(&hard, link, turn);
        compareState(&hard, 0.6);
        if (fabs(turn) < 1e7) /* the oracle's own pi has no more digits */
            compareDihedrals(&hard);
        turnForGood(&hard, link, -turn);
        ctGetPositions(hard.engines[0], after);
        for (int n = 0; n < 3 * LINKS; n++)
            need(before[n] == after[n], &hard, "turned by %g and back, coordinate %d is %.17g, not %.17g", turn, n,
                 after[n], before[n]);
    }
    /* Half turns that add up. */
    for (int i = 0; i < 101; i++)
        turnForGood(&hard, 30, i % 3 == 0 ? PI : -PI);
    compareState(&hard, 0.6);
    compareDihedrals(&hard);
    /* Just this side of pi, and beyond. */
    for (int i = 0; i < 8; i++) {
        turnForGood(&hard, 40, i % 2 == 0 ? nextafter(PI, 4) : -nextafter(PI, 0));
        turnForGood(&hard, 41, i % 2 == 0 ? 0x1p-52 : -0x1p-51);
        compareDihedrals(&hard);
    }
    compareState(&hard, 0.6);
    closeCase(&hard);
    sceneFree(&scene);
}

int main(void)
{
    static const double bends[] = {0.7, 1e-2, 1e-4, 1e-6, 1e-7, 1e-9, 1e-12, 0};
    for (size_t i = 0; i < sizeof bends / sizeof bends[0]; i++) {
        testBend("bonds almost on a line", bends[i], false, 0.1);
        testBend("bonds folded back", bends[i], true, 0.02);
    }
    testTurns();
    return 0;
}
