/* Follows some scenes through thousands of trials and prints a number for each that changes with every bit of what came
 * out: verdicts, energies, neighbours, state and positions. compareTrajectories.cmake builds it in several ways. */
#include "hardcases/sceneBuilder.h"
#include "oracle/randomScene.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static void stop(const char* what)
{
    printf("%s\n", what);
    exit(1);
}

static void succeed(ctStatus status, ctChainTree* tree)
{
    if (status != ctSuccess)
        stop(ctGetErrorText(tree));
}

/* ---- A number for all bits ---- */

/* Fowler, Noll and Vo's. */
static void take(uint64_t* number, const void* data, size_t size)
{
    const unsigned char* bytes = data;
    for (size_t i = 0; i < size; i++)
        *number = (*number ^ bytes[i]) * 0x100000001b3u;
}

static bool takePair(void* number, int particle1, int particle2, double distance)
{
    /* The order of pairs is not defined. */
    uint64_t own = 0xcbf29ce484222325u;
    const int pair[2] = {particle1, particle2};
    take(&own, pair, sizeof pair);
    take(&own, &distance, sizeof distance);
    *(uint64_t*)number += own;
    return true;
}

static void takeState(uint64_t* number, ctChainTree* tree, int particleCount)
{
    uint64_t neighbors = 0;
    double energy;
    const size_t stateSize = ctGetStateSize(tree), coordinates = 3 * (size_t)particleCount;
    double* values = calloc(stateSize + coordinates, sizeof(double));
    if (values == NULL)
        stop("out of memory");
    ctGetState(tree, values);
    ctGetPositions(tree, values + stateSize);
    take(number, values, (stateSize + coordinates) * sizeof(double));
    free(values);
    succeed(ctForEachNeighborPair(tree, 0.5, takePair, &neighbors, NULL), tree);
    succeed(ctComputeEnergy(tree, 1, &energy, NULL, NULL), tree);
    take(number, &neighbors, sizeof neighbors);
    take(number, &energy, sizeof energy);
}

/* ---- The C library ---- */

/* The functions that scenes depend on: C libraries round sines and cosines differently. */
static void printFunctions(void)
{
    uint64_t number = 0xcbf29ce484222325u;
    for (int i = 0; i < 50000; i++) {
        const double x = 6.4 * fmod(i * 0.618033988749894848, 1) - 3.2;
        const double values[3] = {sin(x), cos(x), atan2(sin(x), cos(x))};
        take(&number, values, sizeof values);
    }
    printf("sin, cos and atan2: %016llx\n", (unsigned long long)number);
}

/* ---- Trials ---- */

static ctChange chooseChange(const Scene* scene, int link, double step, randomSource* random)
{
    ctChange change = {.link = link, .angle = randomReal(random, -step, step)};
    if (scene->linkJoints[link] == ctTorsionJoint)
        return change;
    for (int axis = 0; axis < 3; axis++) {
        change.rotation[axis] = randomReal(random, -step, step);
        change.translation[axis] = randomReal(random, -0.1 * step, 0.1 * step);
        change.pivot[axis] = randomReal(random, 0, 3);
    }
    return change;
}

static ctStatus proposeChanges(ctChainTree* tree, const Scene* scene, int trial, double step, randomSource* random)
{
    const int first = randomInt(random, scene->linkCount), second = randomInt(random, scene->linkCount);
    ctChange changes[2];
    int count = 0;
    if (scene->linkJoints[first] != ctFixedJoint)
        changes[count++] = chooseChange(scene, first, trial % 10 == 0 ? 3 : step, random);
    if (second != first && scene->linkJoints[second] != ctFixedJoint && trial % 4 == 0)
        changes[count++] = chooseChange(scene, second, step, random);
    return ctPropose(tree, count, changes);
}

/* Of one to three particles that follow each other, by one shift or by several. */
static ctStatus proposeDisplacements(ctChainTree* tree, const Scene* scene, int trial, double step,
                                     randomSource* random)
{
    const int first = randomInt(random, scene->particleCount);
    ctDisplacement displacements[3];
    int count = 0;
    for (int n = 0; n < 1 + trial % 3; n++) {
        double shift[3];
        for (int axis = 0; axis < 3; axis++)
            shift[axis] = count > 0 && trial % 2 == 0 ? displacements[0].shift[axis] : randomReal(random, -step, step);
        const int particle = (first + n) % scene->particleCount;
        if (scene->linkJoints[scene->particleLinks[particle]] != ctFixedJoint)
            displacements[count++] = (ctDisplacement){particle, {shift[0], shift[1], shift[2]}};
    }
    return count > 0 ? ctProposeDisplacements(tree, count, displacements) : ctPropose(tree, 0, NULL);
}

static void follow(const char* name, const Scene* scene, bool isFlexible, int trials, double step, randomSource* random)
{
    ctDefinition definition = sceneDefinition(scene);
    definition.isFlexible = isFlexible;
    char text[256];
    ctChainTree* tree;
    if (ctCreate(&definition, &tree, text, sizeof text) != ctSuccess)
        stop(text);
    int raised, accepted = 0;
    succeed(ctRaiseLimits(tree, &raised, NULL), tree);
    uint64_t number = 0xcbf29ce484222325u;
    for (int trial = 0; trial < trials; trial++) {
        bool clash;
        succeed(isFlexible && trial % 8 >= 4 ? proposeDisplacements(tree, scene, trial, 0.1, random)
                                             : proposeChanges(tree, scene, trial, step, random),
                tree);
        succeed(ctTestTrial(tree, &clash, NULL, NULL), tree);
        take(&number, &clash, sizeof clash);
        if (!clash)
            succeed(ctAccept(tree, NULL), tree);
        accepted += !clash;
        if (trial % 1000 == 999)
            takeState(&number, tree, scene->particleCount);
    }
    takeState(&number, tree, scene->particleCount);
    printf("%s: %d of %d trials accepted, %016llx\n", name, accepted, trials, (unsigned long long)number);
    ctDestroy(tree);
}

/* ---- Scenes ---- */

/* Rows to and fro, layer upon layer, a little out of line. */
static void addGlobule(Scene* scene, int count, randomSource* random)
{
    const int side = (int)ceil(cbrt(count));
    double(*points)[3] = calloc((size_t)count, sizeof *points);
    if (points == NULL)
        stop("out of memory");
    for (int i = 0; i < count; i++) {
        const int row = i / side, layer = row / side, x = i % side, y = row % side;
        const int site[3] = {row % 2 == 0 ? x : side - 1 - x, layer % 2 == 0 ? y : side - 1 - y, layer};
        for (int axis = 0; axis < 3; axis++)
            points[i][axis] = 0.38 * site[axis] + randomReal(random, -0.03, 0.03);
    }
    addChain(scene, ctFreeJoint, count, (const double(*)[3])points, 0.18, 1);
    free(points);
}

/* Small trees of links of a few particles, some at rest. */
static void addBushes(Scene* scene, int count, randomSource* random)
{
    for (int bush = 0; bush < count; bush++) {
        const double place[3] = {0.6 * (bush % 5), 0.6 * (bush / 5 % 5), 0.6 * (bush / 25)};
        const int root = bush % 7 == 3 ? addFixedLink(scene) : addFreeLink(scene), begin = scene->particleCount;
        for (int i = 0; i < 12; i++) {
            int link = root;
            if (i % 3 == 2) {
                const int inner = begin + randomInt(random, i);
                link = addTorsionLink(scene, scene->particleLinks[inner], inner, begin + i);
            }
            double point[3]; /* compilers would draw arguments in any order */
            for (int axis = 0; axis < 3; axis++)
                point[axis] = place[axis] + randomReal(random, 0, 0.5);
            addParticle(scene, link, point[0], point[1], point[2], i % 5 == 4 ? 0 : 0.08);
        }
    }
}

int main(void)
{
    randomSource random = randomSourceFromSeed(2002);
    Scene globule = {.overlapTolerance = 0.02}, bushes = {.overlapTolerance = 0.01};
    addGlobule(&globule, 900, &random);
    addBushes(&bushes, 75, &random);
    printFunctions();
    follow("globule", &globule, false, 4000, 0.03, &random);
    follow("bushes", &bushes, false, 4000, 0.5, &random);
    follow("flexible globule", &globule, true, 4000, 0.03, &random);
    follow("flexible bushes", &bushes, true, 4000, 0.5, &random);
    sceneFree(&globule);
    sceneFree(&bushes);
    return 0;
}
