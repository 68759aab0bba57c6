/* Random programs of trials, whose energies are compared with those of all pairs in long double. The positions for
 * these come from the oracle, which goes its own way.
 *
 * Usage: TestEnergyPrograms [programs] [seed]. A failure prints its seed, so that "TestEnergyPrograms 1 SEED" runs that
 * program alone. */
#define _POSIX_C_SOURCE 200112L /* setenv */

#include "ctenergy.h"
#include "energies/pairOracle.h"
#include "energies/randomPairSet.h"
#include "oracle/oracle.h"
#include "oracle/randomScene.h"
#include "sceneDefinition.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTICLES = 120, MOST_CHANGES = 6, MOST_PAIR_SETS = 2 };

static const int defaultProgramCount = 60;
static const uint64_t defaultSeed = 20021118;

/* What happened in all programs: proof that the comparison was about something. */
static struct Tally {
    long programs, trials, accepted, changedNear, changedFar, refreshes, infinite;
} tally;

typedef struct Program {
    uint64_t seed;
    randomSource random;
    randomScene scene;
    ctChainTree* tree;
    oracleScene* oracle;
    ctNonbonded nonbonded;
    bool hasNonbonded;
    int pairSetCount;
    randomPairSet pairSets[MOST_PAIR_SETS];
    ctEnergy* energy;
    double* positions;
    int movableCount;
    int* movable;
    bool isJudged;    /* else it only has to have the same bits as one that was */
    uint64_t answers; /* a hash of all energies */
} Program;

static void fail(const Program* p, const char* what, long double value, long double expected)
{
    printf("seed %llu: %s is %.12Lg, not %.12Lg\n", (unsigned long long)p->seed, what, value, expected);
    exit(1);
}

static void* allocate(int count, size_t size)
{
    void* made = calloc((size_t)count + 1, size);
    if (made == NULL)
        abort();
    return made;
}

static double* randomColumn(randomSource* random, int count, double low, double high, double zeros)
{
    double* column = allocate(count, sizeof(double));
    for (int i = 0; i < count; i++)
        column[i] = randomChance(random, zeros) ? 0 : randomReal(random, low, high);
    return column;
}

static void describeNonbonded(Program* p)
{
    int count = p->scene.particleCount;
    ctNonbonded* d = &p->nonbonded;
    d->charges = randomColumn(&p->random, count, -1, 1, 0.1);
    d->sigmas = randomColumn(&p->random, count, 0.01, 0.2, 0.05);
    d->epsilons = randomColumn(&p->random, count, 0, 1, 0.2);
    d->cutoff = randomChance(&p->random, 0.3) ? INFINITY : randomReal(&p->random, 0.2, 1.5);
    d->switchingDistance = randomReal(&p->random, 0.4, 1.4) * (isfinite(d->cutoff) ? d->cutoff : 1);
    d->dielectric = randomReal(&p->random, 1, 80);
    if (isfinite(d->cutoff) && randomChance(&p->random, 0.3))
        d->ewaldAlpha = randomReal(&p->random, 1, 6) / d->cutoff;
    d->exclusionCount = randomInt(&p->random, 3 * count);
    int(*exclusions)[2] = allocate(d->exclusionCount, sizeof *exclusions);
    for (int n = 0; n < d->exclusionCount; n++) {
        int first = randomInt(&p->random, count);
        int second = randomChance(&p->random, 0.8) ? (first + 1 + randomInt(&p->random, 3)) % count
                                                   : randomInt(&p->random, count);
        exclusions[n][0] = first;
        exclusions[n][1] = second;
    }
    d->exclusions = (const int(*)[2])exclusions;
}

static void createEnergy(Program* p, const ctDefinition* definition)
{
    char text[200] = "";
    ctPairSet sets[MOST_PAIR_SETS];
    p->pairSetCount = randomInt(&p->random, MOST_PAIR_SETS + 1);
    for (int n = 0; n < p->pairSetCount; n++) {
        randomPairSetCreate(&p->pairSets[n], &p->random, p->scene.particleCount);
        sets[n] = p->pairSets[n].set;
    }
    p->hasNonbonded = p->pairSetCount == 0 || randomChance(&p->random, 0.5);
    ctEnergyDefinition energy = {.scene = definition,
                                 .nonbonded = p->hasNonbonded ? &p->nonbonded : NULL,
                                 .pairSetCount = p->pairSetCount,
                                 .pairSets = sets};
    if (ctCreateEnergy(p->tree, &energy, &p->energy, text, sizeof text) != ctSuccess) {
        printf("seed %llu: %s\n", (unsigned long long)p->seed, text);
        exit(1);
    }
}

static void createProgram(Program* p, uint64_t seed, bool isJudged)
{
    memset(p, 0, sizeof *p);
    p->isJudged = isJudged;
    p->seed = seed;
    p->random = randomSourceFromSeed(seed);
    do {
        randomSceneDestroy(&p->scene);
        randomSceneCreate(&p->scene, &p->random);
    } while (p->scene.particleCount > MOST_PARTICLES || p->scene.particleCount < 2);
    randomScene* s = &p->scene;
    uint8_t* listed = allocate(s->particleCount, 1);
    memset(listed, 1, (size_t)s->particleCount);
    if (randomChance(&p->random, 0.2))
        memset(s->radii, 0, (size_t)s->particleCount * sizeof(double));
    const ctDefinition definition = defineScene(s, listed);
    p->tree = createDefined(&definition);
    p->oracle = oracleCreate(s->particleCount, s->positions, s->radii, s->roles, s->particleLinks, s->linkCount,
                             s->linkParents, s->linkJoints, s->linkTorsions, s->exclusionCount, s->exclusions,
                             s->overlapTolerance, s->hydrogenBondAllowance);
    p->positions = allocate(3 * s->particleCount, sizeof(double));
    p->movable = allocate(s->linkCount, sizeof(int));
    for (int link = 0; link < s->linkCount; link++) {
        /* A torsion whose axis has no length cannot turn. */
        ctChange turn = {.link = link, .angle = 0.1};
        if (s->linkJoints[link] != ctFixedJoint && ctPropose(p->tree, 1, &turn) == ctSuccess)
            p->movable[p->movableCount++] = link;
    }
    ctReject(p->tree);
    describeNonbonded(p);
    createEnergy(p, &definition);
    free(listed);
}

static void destroyProgram(Program* p)
{
    ctDestroyEnergy(p->energy);
    ctDestroy(p->tree);
    oracleDestroy(p->oracle);
    randomSceneDestroy(&p->scene);
    free((void*)p->nonbonded.charges);
    free((void*)p->nonbonded.sigmas);
    free((void*)p->nonbonded.epsilons);
    free((void*)p->nonbonded.exclusions);
    for (int n = 0; n < p->pairSetCount; n++)
        randomPairSetDestroy(&p->pairSets[n]);
    free(p->positions);
    free(p->movable);
}

/* The energies of Lennard-Jones and Coulomb, and of each pair set; 0 for sets that a program does not have. */
typedef struct PairSums {
    PairSum parts[1 + MOST_PAIR_SETS];
} PairSums;

static PairSums oracleSums(Program* p, int which)
{
    PairSums sums = {0};
    if (!p->isJudged)
        return sums;
    oracleGetPositions(p->oracle, which, p->positions);
    if (p->hasNonbonded)
        sums.parts[0] = sumAllPairs(&p->nonbonded, p->scene.particleCount, p->positions);
    for (int n = 0; n < p->pairSetCount; n++)
        sums.parts[1 + n] = sumPairSet(&p->pairSets[n], p->scene.particleCount, p->positions);
    return sums;
}

static bool isBeyondFloats(long double energy)
{
    return isinf(energy) || isnan(energy) || fabsl(energy) > 1e30L;
}

/* Of all parts; infinite if one is beyond floats. */
static PairSum totalOf(const PairSums* sums)
{
    PairSum total = {0, 0};
    for (int n = 0; n < 1 + MOST_PAIR_SETS; n++) {
        total.energy += isBeyondFloats(sums->parts[n].energy) ? INFINITY : sums->parts[n].energy;
        total.doubt += sums->parts[n].doubt;
    }
    return total;
}

/* Far from the origin, rounding limits the agreement of positions in double with the oracle's. */
static long double placeDoubt(const Program* p)
{
    long double far = 0;
    for (int i = 0; i < 3 * p->scene.particleCount; i++)
        far = fmaxl(far, fabsl((long double)p->positions[i]));
    return far > 1e4L ? INFINITY : 0;
}

static void compare(Program* p, const char* what, double value, PairSum expected)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    p->answers = (p->answers ^ bits) * 0x100000001b3;
    if (!p->isJudged)
        return;
    if (isBeyondFloats(expected.energy)) {
        tally.infinite++;
        return;
    }
    long double doubt = expected.doubt + placeDoubt(p) + 1e-9L;
    if (!(fabsl(value - expected.energy) <= doubt))
        fail(p, what, value, expected.energy);
}

/* All energies that are kept, with those of the state. */
static void compareKept(Program* p, const char* what)
{
    PairSums expected = oracleSums(p, ORACLE_STATE);
    compare(p, what, ctGetPairEnergy(p->energy), expected.parts[0]);
    for (int n = 0; n < p->pairSetCount; n++)
        compare(p, what, ctGetPairSetEnergy(p->energy, n), expected.parts[1 + n]);
}

static double totalKept(const Program* p)
{
    double total = ctGetPairEnergy(p->energy);
    for (int n = 0; n < p->pairSetCount; n++)
        total += ctGetPairSetEnergy(p->energy, n);
    return total;
}

static void refresh(Program* p)
{
    if (ctRefreshEnergy(p->energy, NULL) != ctSuccess)
        fail(p, "a refresh", 1, 0);
    compareKept(p, "the energy of the state");
    tally.refreshes++;
}

static void propose(Program* p)
{
    ctGetPositions(p->tree, p->positions);
    ctChange changes[MOST_CHANGES];
    int links[MOST_CHANGES];
    double flat[MOST_CHANGES * ORACLE_CHANGE_SIZE] = {0};
    int count = randomChance(&p->random, 0.5) ? 1 : 1 + randomInt(&p->random, MOST_CHANGES);
    if (count > p->movableCount)
        count = p->movableCount;
    for (int n = 0; n < count; n++) {
        int chosen = n + randomInt(&p->random, p->movableCount - n);
        links[n] = p->movable[chosen];
        p->movable[chosen] = p->movable[n];
        p->movable[n] = links[n];
        ctChange change = {.link = links[n]};
        double most = randomChance(&p->random, 0.5) ? 0.02 : 3;
        if (p->scene.linkJoints[links[n]] == ctTorsionJoint)
            change.angle = randomReal(&p->random, -most, most);
        else
            for (int axis = 0; axis < 3; axis++) {
                change.rotation[axis] = randomReal(&p->random, -most, most);
                change.translation[axis] = randomReal(&p->random, -0.1, 0.1);
                change.pivot[axis] = p->positions[axis];
            }
        changes[n] = change;
        double* f = flat + n * ORACLE_CHANGE_SIZE;
        f[0] = change.angle;
        memcpy(f + 1, change.rotation, sizeof change.rotation);
        memcpy(f + 4, change.pivot, sizeof change.pivot);
        memcpy(f + 7, change.translation, sizeof change.translation);
    }
    if (ctPropose(p->tree, count, changes) != ctSuccess)
        fail(p, "a proposal", 1, 0);
    oraclePropose(p->oracle, count, links, flat);
}

/* A trial: all parts of its change, or none or some of them. */
static void tryOne(Program* p)
{
    propose(p);
    PairSums sums[2] = {oracleSums(p, ORACLE_STATE), oracleSums(p, ORACLE_TRIAL)};
    PairSum before = totalOf(&sums[0]);
    PairSum after = totalOf(&sums[1]);
    double change = 0;
    int parts = randomChance(&p->random, 0.8) ? CT_ENERGY_PARTS : randomInt(&p->random, CT_ENERGY_PARTS);
    for (int part = 0; part < parts; part++) {
        double ofPart = NAN;
        if (ctComputeEnergyChange(p->energy, (ctEnergyPart)part, &ofPart, NULL) != ctSuccess)
            fail(p, "a change", 1, 0);
        change += ofPart;
        tally.changedNear += part == ctNearPairsPart && ofPart != 0;
        tally.changedFar += part == ctOtherPairsPart && ofPart != 0;
    }
    if (parts == CT_ENERGY_PARTS) {
        PairSum expected = {after.energy - before.energy, before.doubt + after.doubt};
        if (isBeyondFloats(before.energy))
            expected.energy = INFINITY;
        compare(p, "the change", change, expected);
    }
    tally.trials++;
    if (!randomChance(&p->random, 0.5)) {
        ctReject(p->tree);
        oracleReject(p->oracle);
        return;
    }
    if (ctAccept(p->tree, NULL) != ctSuccess)
        fail(p, "an accepted trial", 1, 0);
    oracleAccept(p->oracle);
    tally.accepted++;
    ctStatus accepted = ctAcceptEnergyChange(p->energy);
    if ((accepted == ctSuccess) != (parts == CT_ENERGY_PARTS))
        fail(p, "accepting", accepted, parts);
    if (accepted != ctSuccess)
        refresh(p);
}

/* The stored energy must equal the recomputed energy of the same state within rounding. */
static void compareWithFresh(Program* p)
{
    double kept = totalKept(p);
    PairSums sums = oracleSums(p, ORACLE_STATE);
    PairSum expected = totalOf(&sums);
    compareKept(p, "the energy kept");
    refresh(p);
    double fresh = totalKept(p);
    if (p->isJudged && !isBeyondFloats(expected.energy) && !(fabs(kept - fresh) <= (double)expected.doubt + 1e-9))
        fail(p, "the energy kept against a fresh one", kept, fresh);
}

static void setPositions(Program* p)
{
    ctGetPositions(p->tree, p->positions);
    for (int i = 0; i < 3 * p->scene.particleCount; i++)
        p->positions[i] += randomReal(&p->random, -0.002, 0.002);
    if (ctSetPositions(p->tree, p->positions) != ctSuccess)
        fail(p, "setting positions", 1, 0);
    oracleSetPositions(p->oracle, p->positions);
    if (ctIsEnergyOfState(p->energy))
        fail(p, "whether an energy is that of new positions", 1, 0);
    refresh(p);
}

/* Returns a hash of all energies. */
static uint64_t runProgram(uint64_t seed, const char* instructions, bool isJudged)
{
    setenv("CHAINTREE_SIMD", instructions, 1);
    Program p;
    createProgram(&p, seed, isJudged);
    refresh(&p);
    int steps = p.movableCount > 0 ? 10 + randomInt(&p.random, 30) : 0;
    for (int step = 0; step < steps; step++) {
        tryOne(&p);
        if (randomChance(&p.random, 0.1))
            compareWithFresh(&p);
        if (randomChance(&p.random, 0.05))
            setPositions(&p);
    }
    compareWithFresh(&p);
    destroyProgram(&p);
    tally.programs++;
    return p.answers;
}

int main(int argumentCount, char** arguments)
{
    int programs = argumentCount > 1 ? atoi(arguments[1]) : defaultProgramCount;
    uint64_t seed = argumentCount > 2 ? strtoull(arguments[2], NULL, 10) : defaultSeed;
    for (int n = 0; n < programs; n++, seed++) {
        uint64_t widest = runProgram(seed, "avx512", true);
        if (runProgram(seed, "avx2", false) != widest || runProgram(seed, "portable", false) != widest) {
            printf("seed %llu: instruction sets give other bits\n", (unsigned long long)seed);
            return 1;
        }
    }
    printf("%ld programs, %ld trials, %ld accepted, near changed in %ld, far in %ld, %ld refreshes, %ld infinite\n",
           tally.programs, tally.trials, tally.accepted, tally.changedNear, tally.changedFar, tally.refreshes,
           tally.infinite);
    return tally.accepted > 0 || programs < 10 ? 0 : 1;
}
