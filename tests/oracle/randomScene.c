#include "randomScene.h"

#include "oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void* allocate(int count, size_t size)
{
    void* memory = calloc(count > 0 ? (size_t)count : 1, size);
    if (memory == NULL)
        abort();
    return memory;
}

/* ---- Links ---- */

static int chooseLinkCount(randomSource* random)
{
    static const int edges[] = {1, 2, 3, 15, 16, 17, 31, 32, 33};
    double kind = randomReal(random, 0, 1);
    if (kind < 0.30)
        return edges[randomInt(random, 9)];
    if (kind < 0.34)
        return 255 + randomInt(random, 3);
    if (kind < 0.344)
        return 4095 + randomInt(random, randomChance(random, 0.3) ? 3 : 2500);
    if (kind < 0.85)
        return 1 + randomInt(random, 40);
    return 1 + randomInt(random, 150);
}

enum { CHAIN, CHAIN_WITH_BRANCHES, TREE, STAR, SHAPES };

/* Parents come before their children here; shuffleLinks ends that. */
static void makeLinks(randomScene* scene, randomSource* random)
{
    static const double rootChances[] = {0, 0, 0.05, 0.3, 1};
    static const double fixedChances[] = {0, 0.5, 1};
    static const double innerFreeChances[] = {0, 0, 0.1, 0.5};
    scene->linkCount = chooseLinkCount(random);
    scene->linkParents = allocate(scene->linkCount, sizeof(int));
    scene->linkJoints = allocate(scene->linkCount, 1);
    scene->linkTorsions = allocate(4 * scene->linkCount, sizeof(int));
    int shape = randomInt(random, SHAPES);
    double rootChance = rootChances[randomInt(random, 5)];
    double fixedChance = fixedChances[randomInt(random, 3)];
    double innerFreeChance = innerFreeChances[randomInt(random, 4)];
    int root = 0;
    for (int link = 0; link < scene->linkCount; link++) {
        if (link == 0 || randomChance(random, rootChance)) {
            root = link;
            scene->linkParents[link] = -1;
            scene->linkJoints[link] = randomChance(random, fixedChance) ? ORACLE_FIXED : ORACLE_FREE;
            continue;
        }
        int parent = link - 1;
        if (shape == TREE || (shape == CHAIN_WITH_BRANCHES && randomChance(random, 0.3)))
            parent = root + randomInt(random, link - root);
        else if (shape == STAR)
            parent = root;
        scene->linkParents[link] = parent;
        scene->linkJoints[link] = randomChance(random, innerFreeChance) ? ORACLE_FREE : ORACLE_TORSION;
    }
}

/* ---- Particles ---- */

static int chooseLinkSize(randomSource* random, int kind)
{
    switch (kind) {
    case 0:
        return 1;
    case 1:
        return 1 + randomInt(random, 4);
    case 2:
        return 1 + randomInt(random, 8);
    case 3:
        return 1 + (randomChance(random, 0.1) ? randomInt(random, 60) : randomInt(random, 5));
    default:
        return 14 + randomInt(random, 5);
    }
}

static void makeParticles(randomScene* scene, randomSource* random)
{
    int kind = scene->linkCount > 1000 ? 0 : randomInt(random, scene->linkCount > 60 ? 3 : 5);
    int hasLargeRoot = randomChance(random, 0.15);
    int* sizes = allocate(scene->linkCount, sizeof(int));
    for (int link = 0; link < scene->linkCount; link++) {
        sizes[link] = chooseLinkSize(random, kind);
        if (hasLargeRoot && scene->linkParents[link] < 0 && randomChance(random, 0.5))
            sizes[link] = 100 + randomInt(random, 160);
        if (hasLargeRoot && scene->particleCount > 400)
            sizes[link] = 1;
        scene->particleCount += sizes[link];
    }
    scene->particleLinks = allocate(scene->particleCount, sizeof(int));
    int particle = 0;
    for (int link = 0; link < scene->linkCount; link++)
        for (int n = 0; n < sizes[link]; n++)
            scene->particleLinks[particle++] = link;
    free(sizes);
}

enum { WALK, CROWD, LATTICE, LINE, PLANE, LAYOUTS };

static void makePositions(randomScene* scene, randomSource* random)
{
    static const double offsets[] = {0, 0, 0, 10, 1e3, 1e4};
    int layout = randomChance(random, 0.5) ? WALK : randomInt(random, LAYOUTS);
    double step = randomReal(random, 0.1, 0.4), offset = offsets[randomInt(random, 6)];
    double side = randomReal(random, 0.1, 0.4) * cbrt(scene->particleCount) + 0.2;
    double* centers = allocate(3 * scene->linkCount, sizeof(double));
    for (int link = 0; link < scene->linkCount; link++) {
        int parent = scene->linkParents[link];
        double direction[3];
        randomDirection(random, direction);
        for (int axis = 0; axis < 3; axis++)
            centers[3 * link + axis] =
                parent < 0 ? randomReal(random, -side, side) : centers[3 * parent + axis] + step * direction[axis];
    }
    scene->positions = allocate(3 * scene->particleCount, sizeof(double));
    for (int i = 0; i < scene->particleCount; i++) {
        double* x = scene->positions + 3 * i;
        for (int axis = 0; axis < 3; axis++) {
            if (layout == WALK)
                x[axis] = centers[3 * scene->particleLinks[i] + axis] + randomReal(random, -0.12, 0.12);
            else if (layout == LATTICE)
                x[axis] = 0.2 * randomInt(random, 2 + (int)(side / 0.2));
            else
                x[axis] = randomReal(random, 0, side);
            if ((layout == LINE && axis > 0) || (layout == PLANE && axis > 1))
                x[axis] = 0;
        }
        if (layout == LINE)
            x[0] = 0.15 * i;
        for (int axis = 0; axis < 3; axis++)
            x[axis] += offset;
    }
    free(centers);
}

static double distanceBetween(const randomScene* scene, int i, int j)
{
    const double *x = scene->positions + 3 * i, *y = scene->positions + 3 * j;
    return sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) + (x[2] - y[2]) * (x[2] - y[2]));
}

static double distinctRadius(randomSource* random, int kind, double scale)
{
    if (kind == 1 && randomChance(random, 0.3))
        return 0;
    if (kind == 2 && randomChance(random, 0.01))
        return 10 * scale;
    return kind == 3 ? scale : scale * randomReal(random, 0.5, 1.2);
}

static void makeRadii(randomScene* scene, randomSource* random)
{
    static const double scales[] = {0.01, 0.03, 0.06, 0.1, 0.15};
    double scale = scales[randomInt(random, 5)];
    int kind = randomInt(random, 4), hasBareLinks = randomChance(random, 0.2);
    unsigned char* isBare = allocate(scene->linkCount, 1);
    for (int link = 0; link < scene->linkCount; link++)
        isBare[link] = hasBareLinks && randomChance(random, 0.4);
    if (randomChance(random, 0.01))
        memset(isBare, 1, (size_t)scene->linkCount);
    scene->radii = allocate(scene->particleCount, sizeof(double));
    for (int i = 0; i < scene->particleCount; i++)
        scene->radii[i] = isBare[scene->particleLinks[i]] ? 0 : distinctRadius(random, kind, scale);
    free(isBare);
    scene->overlapTolerance = randomChance(random, 0.4) ? 0 : randomReal(random, 0, 0.05);
    scene->hydrogenBondAllowance = randomChance(random, 0.4) ? 0 : randomReal(random, 0, 0.08);
    if (randomChance(random, 0.6)) {
        scene->roles = allocate(scene->particleCount, 1);
        for (int i = 0; i < scene->particleCount; i++)
            scene->roles[i] = (unsigned char)(randomChance(random, 0.5) ? 0 : randomInt(random, 4));
    }
}

/* ---- Torsions ---- */

/* Particles still lie in the order of their links. */
static int chooseParticleOf(const randomScene* scene, randomSource* random, int link)
{
    int first = 0;
    while (first < scene->particleCount && scene->particleLinks[first] < link)
        first++;
    int end = first;
    while (end < scene->particleCount && scene->particleLinks[end] == link)
        end++;
    return first + randomInt(random, end - first);
}

static int chooseOther(const randomScene* scene, randomSource* random, int other1, int other2, int other3)
{
    int particle;
    do
        particle = randomInt(random, scene->particleCount);
    while (particle == other1 || particle == other2 || particle == other3);
    return particle;
}

/* A torsion joint for which there are too few particles, or no axis, becomes a free joint. */
static void makeTorsions(randomScene* scene, randomSource* random)
{
    for (int link = 0; link < scene->linkCount; link++) {
        if (scene->linkJoints[link] != ORACLE_TORSION)
            continue;
        int inner = chooseParticleOf(scene, random, scene->linkParents[link]);
        int outer = chooseParticleOf(scene, random, link);
        if (scene->particleCount < 4 || distanceBetween(scene, inner, outer) < 1e-3) {
            scene->linkJoints[link] = ORACLE_FREE;
            continue;
        }
        int* torsion = scene->linkTorsions + 4 * link;
        int rootIsAtP3 = randomChance(random, 0.5);
        torsion[1] = rootIsAtP3 ? outer : inner;
        torsion[2] = rootIsAtP3 ? inner : outer;
        torsion[0] = chooseOther(scene, random, inner, outer, outer);
        torsion[3] = chooseOther(scene, random, inner, outer, torsion[0]);
    }
}

static int firstParticleOf(const randomScene* scene, int link)
{
    int first = 0;
    while (scene->particleLinks[first] != link)
        first++;
    return first;
}

/* Every other inner link with a free joint gets a ball joint, about a particle of its parent or of itself. This draws
 * no random numbers, so the rest of the scene does not depend on it. */
static void makeBallJoints(randomScene* scene)
{
    for (int link = 1; link < scene->linkCount; link += 2) {
        int parent = scene->linkParents[link];
        if (scene->linkJoints[link] != ORACLE_FREE || parent < 0)
            continue;
        scene->linkJoints[link] = ORACLE_BALL;
        scene->linkTorsions[4 * link + 1] = firstParticleOf(scene, link % 4 == 1 ? parent : link);
    }
}

/* ---- Exclusions ---- */

static void addExclusion(randomScene* scene, randomSource* random, int i, int j)
{
    int flipped = randomChance(random, 0.5);
    scene->exclusions[2 * scene->exclusionCount] = flipped ? j : i;
    scene->exclusions[2 * scene->exclusionCount + 1] = flipped ? i : j;
    scene->exclusionCount++;
}

static void makeExclusions(randomScene* scene, randomSource* random)
{
    int few = scene->particleCount > 1 ? randomInt(random, scene->particleCount) : 0;
    int excludesNear = randomChance(random, 0.6), count = 0;
    double near = randomReal(random, 0.1, 0.35);
    for (int i = 0; excludesNear && i < scene->particleCount; i++)
        for (int j = 0; j < i; j++)
            count += distanceBetween(scene, i, j) < near;
    scene->exclusions = allocate(2 * (count + few), sizeof(int));
    for (int i = 0; excludesNear && i < scene->particleCount; i++)
        for (int j = 0; j < i; j++)
            if (distanceBetween(scene, i, j) < near)
                addExclusion(scene, random, i, j);
    for (int n = 0; n < few; n++) {
        int i = randomInt(random, scene->particleCount);
        addExclusion(scene, random, i, chooseOther(scene, random, i, i, i));
    }
}

/* ---- Numbering ---- */

static int* shuffledNumbers(randomSource* random, int count)
{
    int* numbers = allocate(count, sizeof(int));
    for (int n = 0; n < count; n++) {
        int other = randomInt(random, n + 1);
        numbers[n] = numbers[other];
        numbers[other] = n;
    }
    return numbers;
}

/* Moves entry n of an array to where[n]. */
static void permute(void* array, int count, size_t size, const int* where)
{
    if (array == NULL)
        return;
    char *entries = array, *old = allocate(count, size);
    memcpy(old, entries, (size_t)count * size);
    for (int n = 0; n < count; n++)
        memcpy(entries + (size_t)where[n] * size, old + (size_t)n * size, size);
    free(old);
}

static void renumber(int* indices, int count, const int* where)
{
    for (int n = 0; n < count; n++)
        if (indices[n] >= 0)
            indices[n] = where[indices[n]];
}

static void shuffleLinks(randomScene* scene, randomSource* random)
{
    int* where = shuffledNumbers(random, scene->linkCount);
    renumber(scene->linkParents, scene->linkCount, where);
    renumber(scene->particleLinks, scene->particleCount, where);
    permute(scene->linkParents, scene->linkCount, sizeof(int), where);
    permute(scene->linkJoints, scene->linkCount, 1, where);
    permute(scene->linkTorsions, scene->linkCount, 4 * sizeof(int), where);
    free(where);
}

static void shuffleParticles(randomScene* scene, randomSource* random)
{
    int* where = shuffledNumbers(random, scene->particleCount);
    renumber(scene->linkTorsions, 4 * scene->linkCount, where);
    renumber(scene->exclusions, 2 * scene->exclusionCount, where);
    permute(scene->positions, scene->particleCount, 3 * sizeof(double), where);
    permute(scene->radii, scene->particleCount, sizeof(double), where);
    permute(scene->roles, scene->particleCount, 1, where);
    permute(scene->particleLinks, scene->particleCount, sizeof(int), where);
    free(where);
}

/* ---- Scenes ---- */

/* Makes a third of the scenes flexible. There a turn is as exact as the places of its axis particles: so not where
 * coordinates are large. Draws no random numbers. */
static int chooseFlexible(const randomScene* scene)
{
    double largest = 0;
    for (int n = 0; n < 3 * scene->particleCount; n++)
        largest = fmax(largest, fabs(scene->positions[n]));
    return largest < 50 && (2 * scene->particleCount + scene->linkCount) % 3 == 0;
}

void randomSceneCreate(randomScene* scene, randomSource* random)
{
    *scene = (randomScene){0};
    makeLinks(scene, random);
    makeParticles(scene, random);
    makePositions(scene, random);
    makeRadii(scene, random);
    makeTorsions(scene, random);
    makeBallJoints(scene);
    makeExclusions(scene, random);
    if (randomChance(random, 0.5))
        shuffleLinks(scene, random);
    if (randomChance(random, 0.5))
        shuffleParticles(scene, random);
    for (int i = 1; i < scene->particleCount; i++)
        scene->extent = fmax(scene->extent, distanceBetween(scene, 0, i));
    scene->isFlexible = chooseFlexible(scene);
}

void randomSceneDestroy(randomScene* scene)
{
    free(scene->positions);
    free(scene->radii);
    free(scene->roles);
    free(scene->particleLinks);
    free(scene->linkParents);
    free(scene->linkJoints);
    free(scene->linkTorsions);
    free(scene->exclusions);
    *scene = (randomScene){0};
}
