#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void setPositions(Program* p)
{
    double* positions = programAllocate(coordinateCount(p), sizeof(double));
    memcpy(positions, randomChance(&p->random, 0.5) ? p->scene.positions : p->state, positionBytes(p));
    double shake = randomChance(&p->random, 0.5) ? 0 : 1e-4;
    for (int n = 0; n < coordinateCount(p); n++)
        positions[n] += randomReal(&p->random, -shake, shake);
    SUCCEED(ctSetPositions(p->tree, positions));
    oracleSetPositions(p->oracle, positions);
    memcpy(p->scene.positions, positions, positionBytes(p));
    memcpy(p->state, positions, positionBytes(p));
    memset(p->hasMoved, 0, (size_t)p->scene.linkCount * sizeof(bool));
    p->hasTrial = false;
    free(positions);
    requireUntouchedState(p);
    requireSameLimits(p);
}

/* Leaves the state behind, and an open trial. */
static void goElsewhere(Program* p)
{
    for (int n = 0; n < 3 && p->movableCount > 0; n++) {
        ctChange change = chooseChange(p, p->movable[randomInt(&p->random, p->movableCount)]);
        if (n > 0)
            SUCCEED(ctAccept(p->tree, NULL));
        SUCCEED(ctPropose(p->tree, 1, &change));
    }
    if (p->scene.isFlexible && p->movableCount > 0 && randomChance(&p->random, 0.7)) {
        const ctDisplacement displacement = chooseDisplacement(p);
        if (ctProposeDisplacements(p->tree, 1, &displacement) == ctSuccess && randomChance(&p->random, 0.7))
            SUCCEED(ctAccept(p->tree, NULL));
    }
}

static void startAnew(Program* p)
{
    ctDestroy(p->tree);
    p->tree = programCreateTree(p);
    p->kept.isStale = p->kept.selection != NULL;
    int(*pairs)[2] = programAllocate(p->limits.count, sizeof(int[2]));
    double* values = programAllocate(p->limits.count, sizeof(double));
    for (int n = 0; n < p->limits.count; n++) {
        memcpy(pairs[n], p->limits.pairs[n].particles, sizeof(int[2]));
        values[n] = p->limits.pairs[n].values[0];
    }
    SUCCEED(ctSetLimits(p->tree, p->limits.count, (const int(*)[2])pairs, values));
    free(pairs);
    free(values);
}

/* Goes back to the state from another one, or in another scene; what follows finds out whether it is the same. */
void setState(Program* p)
{
    size_t size = ctGetStateSize(p->tree);
    double* state = programAllocate((int)size, sizeof(double));
    double* again = programAllocate((int)size, sizeof(double));
    ctGetState(p->tree, state);
    rejectTrial(p);
    if (randomChance(&p->random, 0.5))
        goElsewhere(p);
    else
        startAnew(p);
    SUCCEED(ctSetState(p->tree, state));
    ctGetState(p->tree, again);
    require(memcmp(state, again, size * sizeof(double)) == 0, p, "the state is another one");
    free(state);
    free(again);
    requireUntouchedState(p);
    requireSameLimits(p);
    require(ctValidate(p->tree), p, "ctValidate");
}

/* Particles asked for by their names, from the last to the first, have the bits that they have among all. */
static void compareSinglePositions(Program* p, bool inTrial, const double* expected)
{
    const int count = p->scene.particleCount;
    int* particles = programAllocate(count, sizeof(int));
    double* positions = programAllocate(coordinateCount(p), sizeof(double));
    for (int i = 0; i < count; i++)
        particles[i] = count - 1 - i;
    SUCCEED(ctGetPositionsOf(p->tree, inTrial, count, particles, positions));
    for (int i = 0; i < count; i++)
        memcpy(p->scratch + 3 * particles[i], positions + 3 * i, sizeof(double[3]));
    requireSameBits(p, inTrial ? "single positions of the trial" : "single positions", p->scratch, expected);
    free(positions);
    free(particles);
}

void comparePositions(Program* p)
{
    requireUntouchedState(p);
    requireOraclePositions(p, ORACLE_STATE, p->state);
    compareSinglePositions(p, false, p->state);
    if (p->hasTrial) {
        SUCCEED(ctGetTrialPositions(p->tree, p->scratch));
        requireSameBits(p, "the trial has changed", p->scratch, p->trial);
        compareSinglePositions(p, true, p->trial);
    }
}

/* nm: the least bond of a dihedral in the present positions. */
static double leastBond(const Program* p, const int* torsion)
{
    double least = INFINITY;
    for (int n = 0; n < 3; n++)
        least = fmin(least, oracleDistance(p->oracle, ORACLE_STATE, torsion[n], torsion[n + 1]));
    return least;
}

static bool hasDihedralMoved(const Program* p, const int* torsion)
{
    bool hasMoved = false;
    for (int n = 0; n < 4; n++)
        hasMoved |= hasParticleMoved(p, torsion[n]);
    return hasMoved;
}

void compareTorsionAngle(Program* p)
{
    int link = randomInt(&p->random, p->scene.linkCount);
    double angle, sine;
    if (p->scene.linkJoints[link] != ctTorsionJoint) {
        FAIL(ctInvalidArgument, ctGetTorsionAngle(p->tree, link, &angle));
        return;
    }
    ctStatus status = ctGetTorsionAngle(p->tree, link, &angle);
    double expected = oracleTorsionAngle(p->oracle, link, &sine);
    const int* torsion = p->scene.linkTorsions + 4 * link;
    const bool isPresent = p->scene.isFlexible && hasDihedralMoved(p, torsion); /* and as exact as its bonds */
    const double unit = isPresent ? fmin(1, leastBond(p, torsion)) : 1;
    if (sine * unit > 1e-4) {
        requireStatus(p, "ctGetTorsionAngle", status, ctSuccess);
        require(angle > -PI && angle <= PI, p, "the dihedral of link %d is %.17g", link, angle);
        requireNear(p, "dihedral of link", link, remainder(angle - expected, 2 * PI), 0,
                    numberTolerance(p) / (sine * unit));
    }
    else if (sine == 0 && !isPresent)
        requireStatus(p, "ctGetTorsionAngle", status, ctInvalidArgument);
}

static void compareOrientation(Program* p, int link)
{
    double* rotations = programAllocate(9 * p->scene.linkCount, sizeof(double));
    double expected[9];
    ctGetOrientations(p->tree, (double(*)[9])rotations);
    oracleOrientation(p->oracle, link, expected);
    for (int n = 0; n < 9; n++)
        requireNear(p, "orientation", n, rotations[9 * link + n], expected[n], numberTolerance(p));
    free(rotations);
}

void compareRelativeTransform(Program* p)
{
    int linkA = randomInt(&p->random, p->scene.linkCount), linkB = randomInt(&p->random, p->scene.linkCount);
    ctTransform transform;
    double rotation[9], translation[3];
    SUCCEED(ctGetRelativeTransform(p->tree, linkA, linkB, &transform));
    oracleRelativeTransform(p->oracle, linkA, linkB, rotation, translation);
    for (int n = 0; n < 9; n++)
        requireNear(p, "rotation", n, transform.rotation[n], rotation[n], numberTolerance(p));
    for (int n = 0; n < 3; n++)
        requireNear(p, "translation", n, transform.translation[n], translation[n], numberTolerance(p));
    compareOrientation(p, linkA);
}

void compareCentroid(Program* p)
{
    int link = randomInt(&p->random, p->scene.linkCount);
    double centroid[3], expected[3];
    if (p->scene.linkJoints[link] == ctFixedJoint) {
        FAIL(ctInvalidArgument, ctGetCentroid(p->tree, link, centroid));
        return;
    }
    SUCCEED(ctGetCentroid(p->tree, link, centroid));
    oracleCentroid(p->oracle, link, expected);
    for (int axis = 0; axis < 3; axis++)
        requireNear(p, "centroid coordinate", axis, centroid[axis], expected[axis], numberTolerance(p));
}

void validate(Program* p)
{
    require(ctValidate(p->tree), p, "ctValidate");
    comparePositions(p);
}
