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

void comparePositions(Program* p)
{
    requireUntouchedState(p);
    requireOraclePositions(p, ORACLE_STATE, p->state);
    if (p->hasTrial) {
        SUCCEED(ctGetTrialPositions(p->tree, p->scratch));
        requireSameBits(p, "the trial has changed", p->scratch, p->trial);
    }
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
    if (sine > 1e-4) {
        requireStatus(p, "ctGetTorsionAngle", status, ctSuccess);
        require(angle > -PI && angle <= PI, p, "the dihedral of link %d is %.17g", link, angle);
        requireNear(p, "dihedral of link", link, remainder(angle - expected, 2 * PI), 0, NUMBER_TOLERANCE / sine);
    }
    else if (sine == 0)
        requireStatus(p, "ctGetTorsionAngle", status, ctInvalidArgument);
}

void compareRelativeTransform(Program* p)
{
    int linkA = randomInt(&p->random, p->scene.linkCount), linkB = randomInt(&p->random, p->scene.linkCount);
    ctTransform transform;
    double rotation[9], translation[3];
    SUCCEED(ctGetRelativeTransform(p->tree, linkA, linkB, &transform));
    oracleRelativeTransform(p->oracle, linkA, linkB, rotation, translation);
    for (int n = 0; n < 9; n++)
        requireNear(p, "rotation", n, transform.rotation[n], rotation[n], NUMBER_TOLERANCE);
    for (int n = 0; n < 3; n++)
        requireNear(p, "translation", n, transform.translation[n], translation[n], NUMBER_TOLERANCE);
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
        requireNear(p, "centroid coordinate", axis, centroid[axis], expected[axis], NUMBER_TOLERANCE);
}

void validate(Program* p)
{
    require(ctValidate(p->tree), p, "ctValidate");
    comparePositions(p);
}
