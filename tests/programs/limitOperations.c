#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double toleranceOf(const Program* p, int i, int j)
{
    const unsigned char* roles = p->scene.roles;
    bool bond = roles != NULL && (((roles[i] & ctDonor) && (roles[j] & ctAcceptor)) ||
                                  ((roles[i] & ctAcceptor) && (roles[j] & ctDonor)));
    return p->scene.overlapTolerance + (bond ? p->scene.hydrogenBondAllowance : 0);
}

static PairList getLimits(const Program* p)
{
    int count = ctGetLimitCount(p->tree);
    require(count >= 0, p, "%d limits", count);
    int(*pairs)[2] = programAllocate(count, sizeof(int[2]));
    double* values = programAllocate(count, sizeof(double));
    ctGetLimits(p->tree, count, pairs, values);
    PairList limits = {0};
    for (int n = 0; n < count; n++) {
        require(pairs[n][0] < pairs[n][1], p, "limit of %d-%d is not in order", pairs[n][0], pairs[n][1]);
        appendPair(&limits, pairs[n][0], pairs[n][1], values[n], 0);
        require(n == 0 || comparePairs(limits.pairs + n - 1, limits.pairs + n) < 0, p, "limits are not sorted");
    }
    free(pairs);
    free(values);
    return limits;
}

void requireSameLimits(const Program* p)
{
    PairList limits = getLimits(p);
    require(limits.count == p->limits.count, p, "%d limits, not %d", limits.count, p->limits.count);
    for (int n = 0; n < limits.count; n++)
        require(comparePairs(limits.pairs + n, p->limits.pairs + n) == 0 &&
                    limits.pairs[n].values[0] == p->limits.pairs[n].values[0],
                p, "limit %d is of %d-%d, %g", n, limits.pairs[n].particles[0], limits.pairs[n].particles[1],
                limits.pairs[n].values[0]);
    free(limits.pairs);
}

/* Hands limits to the oracle too, and keeps them. */
static void adoptLimits(Program* p, PairList limits)
{
    free(p->limits.pairs);
    p->limits = limits;
    int* pairs = programAllocate(2 * limits.count, sizeof(int));
    double* values = programAllocate(limits.count, sizeof(double));
    for (int n = 0; n < limits.count; n++) {
        memcpy(pairs + 2 * n, limits.pairs[n].particles, sizeof(int[2]));
        values[n] = limits.pairs[n].values[0];
    }
    oracleSetLimits(p->oracle, limits.count, pairs, values);
    free(pairs);
    free(values);
}

/* ---- Raise ---- */

/* Whether this limit is another than the one we know. */
static bool isRaised(const Program* p, const Pair* limit)
{
    const Pair* old = findPair(&p->limits, limit->particles[0], limit->particles[1]);
    return old == NULL || old->values[0] != limit->values[0];
}

/* Raises limits in the engine, and reads its new limits. */
static int raiseInEngine(Program* p, PairList* limits)
{
    ctCounts counts;
    int raised = -1, different = 0;
    SUCCEED(ctRaiseLimits(p->tree, &raised, chooseCounts(p, &counts)));
    requireCounted(p, &counts);
    *limits = getLimits(p);
    for (int n = 0; n < limits->count; n++)
        different += isRaised(p, limits->pairs + n);
    require(raised == different, p, "%d limits are said to be raised, %d are different", raised, different);
    for (int n = 0; n < p->limits.count; n++)
        require(findPair(limits, p->limits.pairs[n].particles[0], p->limits.pairs[n].particles[1]) != NULL, p,
                "a limit is lost");
    p->tally->raised += raised;
    return raised;
}

void raiseLimits(Program* p)
{
    PairList limits, again;
    raiseInEngine(p, &limits);
    for (int n = 0; n < limits.count; n++) {
        if (!isRaised(p, limits.pairs + n))
            continue;
        const int i = limits.pairs[n].particles[0], j = limits.pairs[n].particles[1];
        double overlap = p->scene.radii[i] + p->scene.radii[j] - oracleDistance(p->oracle, ORACLE_STATE, i, j);
        require(oracleLimitMargin(p->oracle, ORACLE_STATE, i, j) > -DOUBT, p, "%d-%d needed no new limit", i, j);
        requireNear(p, "raised limit", n, limits.pairs[n].values[0], overlap + CT_SIGMA, numberTolerance(p));
    }
    adoptLimits(p, limits);
    int pair[2] = {CT_NULL, CT_NULL};
    double overlap, margin = 0;
    int count = oracleListBeyondLimits(p->oracle, -DOUBT, 1, pair, &overlap, &margin);
    require(count == 0, p, "%d-%d is still %g beyond its limit", pair[0], pair[1], margin);
    require(raiseInEngine(p, &again) == 0, p, "limits are raised twice");
    free(again.pairs);
    requireUntouchedState(p);
}

/* Whether the open trial changes a distance by more than what counts as unmoved. */
static bool isMoved(const Program* p, const int* pair)
{
    const double before = oracleDistance(p->oracle, ORACLE_STATE, pair[0], pair[1]);
    return fabs(oracleDistance(p->oracle, ORACLE_TRIAL, pair[0], pair[1]) - before) > COUNTS_AS_UNMOVED;
}

/* From a state within its limits: a trial is refused just if its state is beyond them, for one distance decides both.
 */
void acceptAndRaiseLimits(Program* p)
{
    if (!p->hasTrial)
        return;
    raiseLimits(p);
    bool clash = testTrial(p);
    acceptInEngine(p);
    PairList limits;
    int raised = raiseInEngine(p, &limits);
    require(!clash || raised > 0, p, "a refused trial is within all limits");
    for (int n = 0; n < limits.count && !clash; n++) {
        const int* pair = limits.pairs[n].particles;
        require(!isRaised(p, limits.pairs + n) || !oracleIsPairChanged(p->oracle, pair[0], pair[1]) ||
                    !isMoved(p, pair),
                p, "%d-%d is beyond its limit after a clash-free trial", pair[0], pair[1]);
    }
    oracleAccept(p->oracle);
    adoptLimits(p, limits);
}

/* ---- Set ---- */

/* Random pairs with random limits. */
static void chooseLimits(Program* p, PairList* wanted)
{
    int count = randomInt(&p->random, 12);
    for (int n = 0; n < count; n++) {
        int i = chooseParticle(p), j = chooseParticle(p);
        int low = i < j ? i : j, high = i < j ? j : i;
        if (low == high || isinf(oracleClashMargin(p->oracle, ORACLE_STATE, low, high)) || findPair(wanted, low, high))
            continue;
        double overlap = p->scene.radii[i] + p->scene.radii[j] - oracleDistance(p->oracle, ORACLE_STATE, i, j);
        double base = randomChance(&p->random, 0.5) ? fmax(0, overlap) : 0;
        bool never = randomChance(&p->random, 0.03); /* may the pair clash */
        appendPair(wanted, low, high, never ? INFINITY : base + randomReal(&p->random, 0, 0.1), 0);
        sortPairs(wanted);
    }
}

void setLimits(Program* p)
{
    PairList wanted = {0}, kept = {0};
    /* Sometimes the present overlaps: the state is then as near to its limits as can be. */
    if (randomChance(&p->random, 0.5))
        chooseLimits(p, &wanted);
    else
        SUCCEED(ctForEachClash(p->tree, collectPair, &wanted, NULL));
    sortPairs(&wanted);
    int(*pairs)[2] = programAllocate(wanted.count, sizeof(int[2]));
    double* values = programAllocate(wanted.count, sizeof(double));
    for (int n = 0; n < wanted.count; n++) {
        const int* pair = wanted.pairs[n].particles;
        bool flipped = randomChance(&p->random, 0.5);
        pairs[n][0] = pair[flipped];
        pairs[n][1] = pair[!flipped];
        values[n] = wanted.pairs[n].values[0];
        if (values[n] > toleranceOf(p, pair[0], pair[1]))
            appendPair(&kept, pair[0], pair[1], values[n], 0);
    }
    SUCCEED(ctSetLimits(p->tree, wanted.count, (const int(*)[2])pairs, values));
    adoptLimits(p, kept);
    requireSameLimits(p);
    requireUntouchedState(p);
    free(wanted.pairs);
    free(pairs);
    free(values);
}
