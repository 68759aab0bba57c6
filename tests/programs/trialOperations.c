#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Propose ---- */

static double chooseAngle(Program* p)
{
    switch (randomInt(&p->random, 8)) {
    case 0:
        return randomReal(&p->random, -PI, PI);
    case 1:
        return randomChance(&p->random, 0.5) ? PI : -PI;
    case 2:
        return 2 * PI * (randomInt(&p->random, 5) - 2);
    case 3:
        return randomReal(&p->random, -30, 30);
    case 4:
        return pow(10, randomReal(&p->random, -16, -3));
    case 5:
        return randomReal(&p->random, -0.01, 0.01);
    default:
        return randomReal(&p->random, -0.5, 0.5);
    }
}

static void chooseVector(Program* p, double length, double* vector)
{
    randomDirection(&p->random, vector);
    for (int axis = 0; axis < 3; axis++)
        vector[axis] *= length;
}

ctChange chooseChange(Program* p, int link)
{
    ctChange change = {.link = link};
    if (p->scene.linkJoints[link] == ctTorsionJoint) {
        change.angle = chooseAngle(p);
        return change;
    }
    if (randomChance(&p->random, 0.8))
        chooseVector(p, chooseAngle(p), change.rotation);
    if (randomChance(&p->random, 0.8))
        chooseVector(p, randomReal(&p->random, 0, randomChance(&p->random, 0.1) ? 20 : 0.3), change.translation);
    memcpy(change.pivot, p->state + 3 * chooseParticle(p), sizeof change.pivot);
    if (randomChance(&p->random, 0.3))
        for (int axis = 0; axis < 3; axis++)
            change.pivot[axis] += randomReal(&p->random, -1, 1);
    return change;
}

static int chooseChangeCount(Program* p)
{
    double kind = randomReal(&p->random, 0, 1);
    int count = 1;
    if (kind < 0.01)
        count = 0;
    else if (kind < 0.03)
        count = p->movableCount;
    else if (kind < 0.4)
        count = 1 + randomInt(&p->random, 8);
    return count < p->movableCount ? count : p->movableCount;
}

/* The numbers of a change in the oracle's order. */
static void flattenChange(const ctChange* change, double* flat)
{
    flat[0] = change->angle;
    memcpy(flat + 1, change->rotation, sizeof change->rotation);
    memcpy(flat + 4, change->pivot, sizeof change->pivot);
    memcpy(flat + 7, change->translation, sizeof change->translation);
}

static int proposeChanges(Program* p)
{
    int count = chooseChangeCount(p);
    ctChange* changes = programAllocate(count, sizeof(ctChange));
    int* links = programAllocate(count, sizeof(int));
    double* flat = programAllocate(ORACLE_CHANGE_SIZE * count, sizeof(double));
    memset(p->isInTrial, 0, (size_t)p->scene.linkCount * sizeof(bool));
    for (int n = 0; n < count; n++) {
        int chosen = n + randomInt(&p->random, p->movableCount - n);
        links[n] = p->movable[chosen];
        p->movable[chosen] = p->movable[n];
        p->movable[n] = links[n];
        changes[n] = chooseChange(p, links[n]);
        flattenChange(changes + n, flat + ORACLE_CHANGE_SIZE * n);
        p->isInTrial[p->roots[links[n]]] = true;
    }
    SUCCEED(ctPropose(p->tree, count, changes));
    oraclePropose(p->oracle, count, links, flat);
    p->displaces = false;
    free(flat);
    free(links);
    free(changes);
    return count;
}

/* In scenes that are not flexible this draws nothing beside changes. */
void propose(Program* p)
{
    const bool displaces = p->scene.isFlexible && randomChance(&p->random, 0.5);
    const int count = displaces ? proposeDisplacements(p) : proposeChanges(p);
    p->hasTrial = true;
    requireUntouchedState(p);
    requireTrialParticles(p);
    SUCCEED(ctGetTrialPositions(p->tree, p->trial));
    requireOraclePositions(p, ORACLE_TRIAL, p->trial);
    if (count % 3 != 0) { /* else what this trial changed is still missing at the next */
        SUCCEED(ctFollowTrialPositions(p->tree, false, p->followed));
        requireSameBits(p, "an array that is kept is not the trial's", p->followed, p->trial);
    }
}

/* ---- Test ---- */

bool testTrial(Program* p)
{
    ctCounts counts;
    bool clash;
    int pair[2] = {CT_NULL, CT_NULL}, worst[2];
    SUCCEED(ctTestTrial(p->tree, &clash, randomChance(&p->random, 0.8) ? pair : NULL, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    double margin = oracleWorstTrialMargin(p->oracle, worst);
    require(clash || margin <= DOUBT, p, "called clash-free; %d-%d is %g beyond its limit", worst[0], worst[1], margin);
    require(!clash || margin > -DOUBT, p, "called clashing at %d-%d; the worst pair is %d-%d with %g", pair[0], pair[1],
            worst[0], worst[1], margin);
    if (clash && pair[0] != CT_NULL) {
        require(pair[0] >= 0 && pair[0] < pair[1] && pair[1] < p->scene.particleCount, p, "%d-%d is no pair", pair[0],
                pair[1]);
        require(oracleIsPairChanged(p->oracle, pair[0], pair[1]), p, "%d-%d moves as one body", pair[0], pair[1]);
        double own = oracleLimitMargin(p->oracle, ORACLE_TRIAL, pair[0], pair[1]);
        require(own > -DOUBT, p, "%d-%d is given as clashing, with %g", pair[0], pair[1], own);
    }
    p->tally->doubtful += fabs(margin) <= DOUBT;
    p->tally->clashing += clash;
    p->tally->clashFree += !clash;
    return clash;
}

void compareVerdicts(Program* p)
{
    if (!p->hasTrial)
        return;
    bool clash = testTrial(p);
    require(testTrial(p) == clash, p, "a second look gives another verdict");
    requireUntouchedState(p);
}

void compareChangedPairs(Program* p)
{
    if (!p->hasTrial)
        return;
    double cutoff = chooseCutoff(p);
    int count = oracleListChangedPairs(p->oracle, cutoff + DOUBT, 0, NULL, NULL, NULL);
    Expected expected = expectedCreate(count);
    oracleListChangedPairs(p->oracle, cutoff + DOUBT, count, expected.particles, expected.values, expected.others);
    for (int e = 0; e < count; e++)
        expected.margins[e] = fabs(expected.values[e] - expected.others[e]) <= COUNTS_AS_UNMOVED
                                  ? 0
                                  : cutoff - fmin(expected.values[e], expected.others[e]);
    PairList list = {0};
    ctCounts counts;
    SUCCEED(ctForEachChangedPair(p->tree, cutoff, collectChangedPair, &list, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    requireSameList(p, &list, &expected, 2);
    requireUntouchedState(p);
    p->tally->changed += list.count;
    free(list.pairs);
    expectedDestroy(&expected);
}

/* ---- End ---- */

void acceptInEngine(Program* p)
{
    ctCounts counts;
    ctCounts* wanted = chooseCounts(p, &counts);
    if (p->displaces)
        acceptDisplacements(p, wanted);
    else
        SUCCEED(ctAccept(p->tree, wanted));
    requireCounted(p, &counts);
    memcpy(p->state, p->trial, positionBytes(p));
    p->hasTrial = false;
    for (int link = 0; link < p->scene.linkCount; link++)
        p->hasMoved[link] |= p->isInTrial[link];
    requireUntouchedState(p);
    for (int i = 0; i < p->scene.particleCount; i++)
        require(hasParticleMoved(p, i) || memcmp(p->state + 3 * i, p->scene.positions + 3 * i, sizeof(double[3])) == 0,
                p, "the molecule of particle %d has not moved, but lost its reference bits", i);
}

void acceptTrial(Program* p)
{
    if (!p->hasTrial)
        return;
    acceptInEngine(p);
    oracleAccept(p->oracle);
}

static void listNeighbors(Program* p, double cutoff, PairList* list)
{
    SUCCEED(ctForEachNeighborPair(p->tree, cutoff, collectPair, list, NULL));
    sortCollected(p, list);
}

/* A pair that a trial changes is listed before and after it just if the trial says so: one distance decides it all. */
void acceptAndCompareLists(Program* p)
{
    if (!p->hasTrial)
        return;
    double cutoff = chooseCutoff(p);
    PairList before = {0}, changed = {0}, after = {0};
    listNeighbors(p, cutoff, &before);
    SUCCEED(ctForEachChangedPair(p->tree, cutoff, collectChangedPair, &changed, NULL));
    sortCollected(p, &changed);
    acceptTrial(p);
    listNeighbors(p, cutoff, &after);
    for (int n = 0; n < changed.count; n++) {
        const Pair* pair = changed.pairs + n;
        const int i = pair->particles[0], j = pair->particles[1];
        require((findPair(&before, i, j) != NULL) == (pair->values[0] <= cutoff), p, "%d-%d: not as before the trial",
                i, j);
        require((findPair(&after, i, j) != NULL) == (pair->values[1] <= cutoff), p, "%d-%d: not as in the trial", i, j);
    }
    free(before.pairs);
    free(changed.pairs);
    free(after.pairs);
}

/* A rejected trial leaves the numbers of the state, too. */
void rejectTrial(Program* p)
{
    const size_t size = ctGetStateSize(p->tree);
    double* before = programAllocate((int)size, sizeof(double));
    double* after = programAllocate((int)size, sizeof(double));
    ctGetState(p->tree, before);
    ctReject(p->tree);
    ctGetState(p->tree, after);
    require(memcmp(before, after, size * sizeof(double)) == 0, p, "a rejected trial changes the state");
    free(before);
    free(after);
    oracleReject(p->oracle);
    p->hasTrial = false;
    requireUntouchedState(p);
}
