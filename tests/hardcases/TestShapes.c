/* Chains whose boxes have no width, no depth or no direction: straight, planar, coiled and helical ones. */
#include "hardcase.h"

#include <math.h>
#include <stddef.h>

enum { LINKS = 300 };

typedef void Curve(double t, double* point);

static void alongAxis(double t, double* point)
{
    point[0] = t;
}

static void alongDiagonal(double t, double* point)
{
    point[0] = point[1] = point[2] = t / sqrt(3);
}

/* A line but for what looks like rounding. */
static void almostLine(double t, double* point)
{
    point[0] = t;
    point[1] = 1e-9 * sin(7 * t);
    point[2] = 1e-13 * cos(3 * t);
}

static void zigzag(double t, double* point)
{
    point[0] = 0.8 * t;
    point[1] = (int)(t / 0.4 + 0.5) % 2 == 0 ? 0 : 0.25;
}

/* Of Archimedes, whose turns lie 0.5 apart. */
static void flatSpiral(double t, double* point)
{
    const double turned = sqrt(4 * acos(-1) * t / 0.5) + 3;
    point[0] = 0.5 / (2 * acos(-1)) * turned * cos(turned);
    point[1] = 0.5 / (2 * acos(-1)) * turned * sin(turned);
}

static void narrowHelix(double t, double* point)
{
    point[0] = 0.3 * cos(2 * t);
    point[1] = 0.3 * sin(2 * t);
    point[2] = 0.75 * t;
}

/* Turns that lie on one another like those of a spring. */
static void wideHelix(double t, double* point)
{
    point[0] = 2 * cos(t / 2);
    point[1] = 2 * sin(t / 2);
    point[2] = 0.5 * t / (4 * acos(-1));
}

/* A helix whose axis is a helix. */
static void coiledCoil(double t, double* point)
{
    const double s = t / 6, out = 1 + 0.4 * cos(2.4 * t);
    point[0] = 2 * out * cos(s);
    point[1] = 2 * out * sin(s);
    point[2] = 0.8 * sin(2.4 * t) + 0.6 * s;
}

/* The same place again after every fourth. */
static void square(double t, double* point)
{
    const int corner = (int)(t / 0.4 + 0.5) % 4;
    point[0] = corner == 1 || corner == 2 ? 0.4 : 0;
    point[1] = corner >= 2 ? 0.4 : 0;
}

static const struct {
    const char* name;
    Curve* curve;
} shapes[] = {{"along an axis", alongAxis}, {"along a diagonal", alongDiagonal}, {"almost a line", almostLine},
              {"a zigzag", zigzag},         {"a flat spiral", flatSpiral},       {"a narrow helix", narrowHelix},
              {"a wide helix", wideHelix},  {"a coiled coil", coiledCoil},       {"a square, again and again", square}};

static void testShape(const char* name, Curve* curve, double radius)
{
    static double points[LINKS][3];
    for (int i = 0; i < LINKS; i++) {
        points[i][0] = points[i][1] = points[i][2] = 0;
        curve(0.4 * i, points[i]);
    }
    Scene scene = {.overlapTolerance = 0.02};
    addChain(&scene, ctFreeJoint, LINKS, (const double(*)[3])points, radius, 1);
    HardCase hard;
    openCase(&hard, name, &scene);
    raiseLimits(&hard);
    randomSource random = randomSourceFromSeed(6);
    wander(&hard, &random, 60, 0.2, 0.7);
    closeCase(&hard);
    sceneFree(&scene);
}

int main(void)
{
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
        testShape(shapes[i].name, shapes[i].curve, 0.15);
        testShape(shapes[i].name, shapes[i].curve, 0.001);
    }
    return 0;
}
