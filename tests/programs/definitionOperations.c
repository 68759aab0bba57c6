#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Copies ---- */

/* The arrays of a definition, to be changed. */
typedef struct Copies {
    double *positions, *radii;
    unsigned char *roles, *joints;
    int *particleLinks, *parents, *torsions, *exclusions;
} Copies;

static void* copyOf(const void* array, int count, size_t size)
{
    void* copy = programAllocate(count, size);
    if (array != NULL && count > 0)
        memcpy(copy, array, (size_t)count * size);
    return copy;
}

/* The program's definition in separate arrays. */
static ctDefinition copyDefinition(const Program* p, Copies* copies)
{
    ctDefinition d = programDefinition(p);
    *copies = (Copies){copyOf(d.positions, 3 * d.particleCount, sizeof(double)),
                       copyOf(d.radii, d.particleCount, sizeof(double)),
                       copyOf(d.hydrogenBondRoles, d.particleCount, 1),
                       copyOf(d.linkJoints, d.linkCount, 1),
                       copyOf(d.particleLinks, d.particleCount, sizeof(int)),
                       copyOf(d.linkParents, d.linkCount, sizeof(int)),
                       copyOf(d.linkTorsions, d.linkCount, sizeof(int[4])),
                       copyOf(d.exclusions, d.exclusionCount, sizeof(int[2]))};
    d.positions = copies->positions;
    d.radii = copies->radii;
    d.hydrogenBondRoles = copies->roles;
    d.particleLinks = copies->particleLinks;
    d.linkParents = copies->parents;
    d.linkJoints = copies->joints;
    d.linkTorsions = (const int(*)[4])copies->torsions;
    d.exclusions = (const int(*)[2])copies->exclusions;
    return d;
}

static void freeArrays(Copies* copies)
{
    free(copies->positions);
    free(copies->radii);
    free(copies->roles);
    free(copies->joints);
    free(copies->particleLinks);
    free(copies->parents);
    free(copies->torsions);
    free(copies->exclusions);
}

/* ---- Nonsense ---- */

static int chooseNoIndex(Program* p, int count)
{
    const int none[] = {-2, -1 - randomInt(&p->random, 1000), count, count + randomInt(&p->random, 1000)};
    return none[randomInt(&p->random, 4)];
}

static double chooseNoRadius(Program* p)
{
    return randomChance(&p->random, 0.5) ? -randomReal(&p->random, 1e-9, 1) : chooseNoLength(p);
}

/* A root that hangs on a link which hangs on it. */
static void closeRing(Copies* copies, int link)
{
    int root = link;
    while (copies->parents[root] != CT_NULL)
        root = copies->parents[root];
    copies->parents[root] = link;
    copies->joints[root] = ctFreeJoint;
}

static void spoilLink(Program* p, Copies* copies, ctDefinition* d)
{
    const int link = randomInt(&p->random, d->linkCount);
    switch (randomInt(&p->random, 5)) {
    case 0:
        copies->parents[link] = chooseNoIndex(p, d->linkCount);
        if (copies->parents[link] == CT_NULL)
            copies->joints[link] = ctTorsionJoint; /* which needs a parent */
        break;
    case 1:
        copies->joints[link] = (unsigned char)(4 + randomInt(&p->random, 252));
        break;
    case 2:
        closeRing(copies, link);
        break;
    case 3:
        copies->particleLinks[chooseParticle(p)] = chooseNoIndex(p, d->linkCount);
        break;
    default:
        if (copies->joints[link] == ctTorsionJoint)
            copies->torsions[4 * link + randomInt(&p->random, 4)] = chooseNoIndex(p, d->particleCount);
        else if (copies->joints[link] == ctBallJoint)
            copies->torsions[4 * link + 1] = chooseNoIndex(p, d->particleCount);
        else
            copies->joints[link] = copies->parents[link] == CT_NULL ? ctTorsionJoint : ctFixedJoint;
    }
}

static void spoil(Program* p, Copies* copies, ctDefinition* d)
{
    const int particle = chooseParticle(p);
    switch (randomInt(&p->random, 7)) {
    case 0:
        copies->positions[3 * particle + randomInt(&p->random, 3)] = chooseNoLength(p);
        break;
    case 1:
        copies->radii[particle] = chooseNoRadius(p);
        break;
    case 2:
        copies->roles[particle] = (unsigned char)(4 + randomInt(&p->random, 252));
        break;
    case 3:
        if (d->exclusionCount > 0) {
            int* exclusion = copies->exclusions + 2 * randomInt(&p->random, d->exclusionCount);
            exclusion[1] = randomChance(&p->random, 0.5) ? exclusion[0] : chooseNoIndex(p, d->particleCount);
            break;
        }
        /* fall through */
    case 4:
        d->overlapTolerance = chooseNoRadius(p);
        break;
    case 5:
        d->hydrogenBondAllowance = chooseNoRadius(p);
        break;
    default:
        spoilLink(p, copies, d);
    }
}

void createNonsense(Program* p)
{
    Copies copies;
    ctDefinition definition = copyDefinition(p, &copies);
    spoil(p, &copies, &definition);
    ctChainTree* tree = p->tree; /* anything but NULL */
    char text[200] = "";
    ctStatus status = ctCreate(&definition, &tree, text, sizeof text);
    require(status == ctInvalidArgument && tree == NULL && text[0] != '\0', p, "ctCreate returned %d: %s", (int)status,
            text);
    freeArrays(&copies);
    requireUntouchedState(p);
}

/* ---- Extremes ---- */

static double chooseExtreme(Program* p)
{
    static const double extremes[] = {1e15, 1e12, 1e9, 1e6, 1e3, 1e-10, 1e-40, 1e-300, 5e-324, 0};
    return extremes[randomInt(&p->random, 10)];
}

static void makeExtreme(Program* p, Copies* copies, ctDefinition* d)
{
    for (int n = randomInt(&p->random, 6); n >= 0; n--) {
        const int particle = chooseParticle(p);
        if (randomChance(&p->random, 0.7))
            copies->positions[3 * particle + randomInt(&p->random, 3)] =
                chooseExtreme(p) * (randomChance(&p->random, 0.5) ? -1 : 1);
        else
            copies->radii[particle] = chooseExtreme(p);
    }
    if (randomChance(&p->random, 0.1))
        d->overlapTolerance = chooseExtreme(p);
}

static ctChange chooseExtremeChange(Program* p, const ctDefinition* d)
{
    const int link = randomInt(&p->random, d->linkCount);
    ctChange change = {.link = link, .angle = chooseExtreme(p)};
    for (int axis = 0; axis < 3; axis++) {
        change.rotation[axis] = randomChance(&p->random, 0.5) ? 0 : chooseExtreme(p);
        change.translation[axis] = randomChance(&p->random, 0.5) ? 0 : -chooseExtreme(p);
        change.pivot[axis] = randomChance(&p->random, 0.5) ? 0 : chooseExtreme(p);
    }
    return change;
}

/* The answers are not checked, but every call must return. */
static void askAll(Program* p, ctChainTree* tree)
{
    const int first[] = {0};
    const double position[3] = {chooseExtreme(p), 0, 1};
    double* numbers = programAllocate((int)ctGetStateSize(tree), sizeof(double));
    double energy, distance, angle;
    bool clash;
    int pair[2], raised;
    PairList list = {.end = 100};
    ctSelection *some, *one;
    ctHasClash(tree, &clash, pair, NULL);
    ctForEachClash(tree, collectPair, &list, NULL);
    ctForEachNeighborPair(tree, chooseExtreme(p), collectPair, &list, NULL);
    ctForEachChangedPair(tree, chooseExtreme(p), collectChangedPair, &list, NULL);
    ctForEachClashWith(tree, position, chooseExtreme(p), collectParticle, &list, NULL);
    ctComputeEnergy(tree, chooseExtreme(p), &energy, numbers, NULL);
    SUCCEED(ctSelect(tree, 1, first, &one));
    SUCCEED(ctSelect(tree, p->movableCount, p->movable, &some)); /* a link has a particle, so these are particles too */
    ctGetMinimumDistance(tree, one, some, &distance, pair, NULL);
    ctFreeSelection(some);
    ctFreeSelection(one);
    ctGetTorsionAngle(tree, randomInt(&p->random, p->scene.linkCount), &angle);
    ctRaiseLimits(tree, &raised, NULL);
    ctGetState(tree, numbers);
    SUCCEED(ctSetState(tree, numbers));
    ctValidate(tree);
    free(numbers);
    free(list.pairs);
}

/* In a flexible scene: displaces a particle by as much as it may be, or more. */
static void displaceFar(Program* p, const ctDefinition* d, ctChainTree* tree)
{
    if (!d->isFlexible)
        return;
    ctDisplacement displacement = {.particle = chooseParticle(p)};
    for (int axis = 0; axis < 3; axis++)
        displacement.shift[axis] = randomChance(&p->random, 0.5) ? 0 : chooseExtreme(p);
    bool clash;
    if (ctProposeDisplacements(tree, 1, &displacement) == ctSuccess)
        SUCCEED(ctTestTrial(tree, &clash, NULL, NULL));
    askAll(p, tree);
    ctAccept(tree, NULL);
}

static double largestNumber(const Program* p, const ctDefinition* d)
{
    double largest = 0;
    for (int n = 0; n < coordinateCount(p); n++)
        largest = fmax(largest, fabs(d->positions[n]));
    for (int i = 0; i < d->particleCount; i++)
        largest = fmax(largest, d->radii[i]);
    return largest;
}

/* No clash is lost, but to the rounding of a difference of coordinates. */
static void requireClashes(Program* p, const ctDefinition* d, ctChainTree* tree)
{
    const double largest = largestNumber(p, d), slack = CT_SIGMA + 1e-15 * largest;
    oracleScene* oracle = createOracle(d);
    int count = oracleListClashes(oracle, -slack, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListClashes(oracle, -slack, count, expected.particles, expected.values, expected.margins);
    PairList list = {0};
    SUCCEED(ctForEachClash(tree, collectPair, &list, NULL));
    sortCollected(p, &list);
    for (int e = 0; e < count; e++) {
        const int* pair = expected.particles + 2 * e;
        require(findPair(&list, pair[0], pair[1]) != NULL, p, "%d-%d is missing; it is %g beyond the limit", pair[0],
                pair[1], expected.margins[e]);
    }
    free(list.pairs);
    expectedDestroy(&expected);
    oracleDestroy(oracle);
}

void goToExtremes(Program* p)
{
    Copies copies;
    ctDefinition definition = copyDefinition(p, &copies);
    makeExtreme(p, &copies, &definition);
    ctChainTree* tree;
    ctStatus status = ctCreate(&definition, &tree, NULL, 0);
    require(status == ctSuccess, p, "ctCreate returned %d", (int)status);
    requireClashes(p, &definition, tree);
    for (int n = randomInt(&p->random, 4); n >= 0; n--) {
        const ctChange change = chooseExtremeChange(p, &definition);
        bool clash;
        if (ctPropose(tree, 1, &change) == ctSuccess)
            SUCCEED(ctTestTrial(tree, &clash, NULL, NULL));
        askAll(p, tree);
        ctAccept(tree, NULL);
        displaceFar(p, &definition, tree);
    }
    ctDestroy(tree);
    freeArrays(&copies);
}
