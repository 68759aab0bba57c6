#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void callWithoutTrial(Program* p)
{
    if (p->hasTrial)
        return;
    bool clash;
    PairList list = {0};
    FAIL(ctNoTrial, ctTestTrial(p->tree, &clash, NULL, NULL));
    FAIL(ctNoTrial, ctGetTrialPositions(p->tree, p->scratch));
    FAIL(ctNoTrial, ctGetPositionsOf(p->tree, true, 0, NULL, p->scratch));
    FAIL(ctNoTrial, ctForEachChangedPair(p->tree, 0.5, collectChangedPair, &list, NULL));
    FAIL(ctNoTrial, ctAccept(p->tree, NULL));
    require(list.count == 0, p, "pairs came without a trial");
    requireUntouchedState(p);
}

static void proposeNonsenseFor(Program* p, int link)
{
    ctChange changes[2] = {chooseChange(p, link), chooseChange(p, link)};
    FAIL(ctInvalidArgument, ctPropose(p->tree, 2, changes));
    if (p->scene.linkJoints[link] == ctTorsionJoint)
        changes[0].angle = randomChance(&p->random, 0.5) ? NAN : INFINITY;
    else {
        double* vectors[] = {changes[0].rotation, changes[0].pivot, changes[0].translation};
        const int vector = randomInt(&p->random, 3);
        const bool isBall = p->scene.linkJoints[link] == ctBallJoint;
        vectors[isBall ? 0 : vector][randomInt(&p->random, 3)] = chooseNoLength(p);
    }
    FAIL(ctInvalidArgument, ctPropose(p->tree, 1, changes));
}

void proposeNonsense(Program* p)
{
    const ctChange below = {.link = -1}, beyond = {.link = p->scene.linkCount};
    FAIL(ctInvalidArgument, ctPropose(p->tree, 1, &below));
    FAIL(ctInvalidArgument, ctPropose(p->tree, 1, &beyond));
    FAIL(ctInvalidArgument, ctPropose(p->tree, -1, &below));
    int link = randomInt(&p->random, p->scene.linkCount);
    if (p->scene.linkJoints[link] == ctFixedJoint) {
        const ctChange fixed = {.link = link};
        FAIL(ctInvalidArgument, ctPropose(p->tree, 1, &fixed));
    }
    if (p->movableCount > 0)
        proposeNonsenseFor(p, p->movable[randomInt(&p->random, p->movableCount)]);
    displaceNonsense(p);
    comparePositions(p);
}

void queryNonsense(Program* p)
{
    PairList list = {0};
    double value, vector[3] = {0, chooseNoLength(p), 0};
    int particle = 0, below = -1, beyond = p->scene.particleCount, pair[2];
    ctTransform transform;
    ctSelection *none, *one;
    FAIL(ctInvalidArgument, ctForEachNeighborPair(p->tree, 0, collectPair, &list, NULL));
    FAIL(ctInvalidArgument, ctForEachNeighborPair(p->tree, -0.1, collectPair, &list, NULL));
    FAIL(ctInvalidArgument, ctForEachNeighborPair(p->tree, NAN, collectPair, &list, NULL));
    if (p->hasTrial)
        FAIL(ctInvalidArgument, ctForEachChangedPair(p->tree, -1, collectChangedPair, &list, NULL));
    FAIL(ctInvalidArgument, ctForEachClashWith(p->tree, vector, 0.1, collectParticle, &list, NULL));
    FAIL(ctInvalidArgument, ctForEachClashWith(p->tree, p->state, -0.1, collectParticle, &list, NULL));
    FAIL(ctInvalidArgument, ctSelect(p->tree, 1, &beyond, &none));
    FAIL(ctInvalidArgument, ctGetPositionsOf(p->tree, false, 1, &beyond, vector));
    FAIL(ctInvalidArgument, ctGetPositionsOf(p->tree, p->hasTrial, 1, &below, vector));
    SUCCEED(ctSelect(p->tree, 0, NULL, &none));
    SUCCEED(ctSelect(p->tree, 1, &particle, &one));
    FAIL(ctInvalidArgument, ctGetMinimumDistance(p->tree, none, one, &value, pair, NULL));
    FAIL(ctInvalidArgument, ctGetMinimumDistance(p->tree, one, one, &value, pair, NULL));
    ctFreeSelection(none);
    ctFreeSelection(one);
    FAIL(ctInvalidArgument, ctGetTorsionAngle(p->tree, p->scene.linkCount, &value));
    FAIL(ctInvalidArgument, ctGetCentroid(p->tree, -1, vector));
    FAIL(ctInvalidArgument, ctGetRelativeTransform(p->tree, 0, p->scene.linkCount, &transform));
    FAIL(ctInvalidArgument, ctComputeEnergy(p->tree, NAN, &value, NULL, NULL));
    require(list.count == 0, p, "pairs came from a failed call");
    requireUntouchedState(p);
}

void setNonsense(Program* p)
{
    memcpy(p->scratch, p->state, positionBytes(p));
    p->scratch[randomInt(&p->random, coordinateCount(p))] = chooseNoLength(p);
    FAIL(ctInvalidArgument, ctSetPositions(p->tree, p->scratch));
    const size_t size = ctGetStateSize(p->tree);
    double* state = programAllocate((int)size, sizeof(double));
    ctGetState(p->tree, state);
    state[randomInt(&p->random, (int)size)] = chooseNoLength(p);
    FAIL(ctInvalidArgument, ctSetState(p->tree, state));
    free(state);
    const int pairs[][2] = {{0, p->scene.particleCount}, {0, 0}, {-1, 0}, {0, 1}};
    const double limit = 0.1, bad = NAN;
    for (int n = 0; n < 3; n++)
        FAIL(ctInvalidArgument, ctSetLimits(p->tree, 1, pairs + n, &limit));
    FAIL(ctInvalidArgument, ctSetLimits(p->tree, 1, pairs + 3, &bad));
    requireSameLimits(p);
    comparePositions(p);
}
