/* The stand-in for Born solvation in random programs of trials: its energy against all pairs in long double, changes of
 * trials against the states before and after, near pairs there against near pairs back, and the bits of each
 * instruction set. Two of five scenes are in a periodic box; in half of all, trials displace particles, too.
 *
 * Usage: TestStandIn [programs] [seed]. A failure prints its seed. */
#define _POSIX_C_SOURCE 200112L /* setenv */

#include "ctenergy.h"
#include "energies/standInOracle.h"
#include "oracle/randomScene.h"
#include "sceneDefinition.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTICLES = 300, NECK_TYPES = 3 };

static const int defaultProgramCount = 100;
static const uint64_t defaultSeed = 20261122;

static struct Tally {
    long programs, trials, displacements, accepted, compared, ambiguous, bentBack, ways, otherWays;
} tally;

typedef struct Program {
    uint64_t seed;
    randomSource random;
    randomScene scene;
    ctChainTree* tree;
    ctEnergy* energy;
    ctNonbonded nonbonded;
    ctBorn born;
    ctStandIn standIn;
    ctEnergyDefinition definition;
    double columns[12][MOST_PARTICLES];
    int neckTypes[MOST_PARTICLES];
    double necks[2][NECK_TYPES * NECK_TYPES];
    int exclusions[3 * MOST_PARTICLES][2];
    double far[MOST_PARTICLES];
    double box[3][3];
    bool isPeriodic;
    bool isFlexible;
    double positions[3 * MOST_PARTICLES];
    bool isJudged;
    uint64_t answers;
} Program;

static void fail(const Program* p, const char* what, long double value, long double expected)
{
    printf("seed %llu: %s is %.12Lg, not %.12Lg\n", (unsigned long long)p->seed, what, value, expected);
    exit(1);
}

static const double* column(Program* p, int number, double low, double high)
{
    for (int i = 0; i < p->scene.particleCount; i++)
        p->columns[number][i] = randomReal(&p->random, low, high);
    return p->columns[number];
}

static void describe(Program* p)
{
    const int count = p->scene.particleCount;
    randomSource* random = &p->random;
    p->nonbonded = (ctNonbonded){.charges = column(p, 0, -0.8, 0.8),
                                 .sigmas = column(p, 1, 0.01, 0.1),
                                 .epsilons = column(p, 2, 0, 0.5),
                                 .cutoff = INFINITY,
                                 .switchingDistance = INFINITY,
                                 .dielectric = 1};
    p->nonbonded.exclusionCount = randomInt(random, 3 * count);
    for (int n = 0; n < p->nonbonded.exclusionCount; n++) {
        p->exclusions[n][0] = randomInt(random, count);
        p->exclusions[n][1] = (p->exclusions[n][0] + 1 + randomInt(random, 3)) % count;
    }
    p->nonbonded.exclusions = (const int(*)[2])p->exclusions;
    ctBorn* d = &p->born;
    *d = (ctBorn){.charges = randomChance(random, 0.7) ? p->columns[0] : column(p, 3, -0.8, 0.8),
                  .radii = column(p, 4, 0.12, 0.2),
                  .isRescaled = randomChance(random, 0.8),
                  .coulomb = 138.935485,
                  .soluteDielectric = randomReal(random, 1, 3),
                  .solventDielectric = randomReal(random, 20, 90),
                  .kappa = randomChance(random, 0.4) ? randomReal(random, 0.1, 3) : 0,
                  .surfaceEnergy = randomChance(random, 0.5) ? 28.4 : 0,
                  .probeRadius = 0.14,
                  .cutoff = INFINITY};
    for (int i = 0; i < count; i++) {
        p->columns[5][i] = p->columns[4][i] - 0.01;
        p->columns[6][i] = p->columns[5][i] * (randomChance(random, 0.1) ? -0.5 : randomReal(random, 0.05, 0.5));
        p->neckTypes[i] = randomInt(random, NECK_TYPES);
        p->far[i] = randomReal(random, 0, 0.5);
    }
    d->offsetRadii = p->columns[5];
    d->scaledRadii = p->columns[6];
    d->alphas = column(p, 7, 0.8, 1.1);
    d->betas = column(p, 8, 0, 0.9);
    d->gammas = column(p, 9, 0.5, 4.9);
    d->neckTypeCount = randomChance(random, 0.5) ? NECK_TYPES : 0;
    for (int n = 0; n < NECK_TYPES * NECK_TYPES; n++) {
        p->necks[0][n] = randomReal(random, 0, 0.5);
        p->necks[1][n] = randomReal(random, 0.2, 0.4);
    }
    d->neckTypes = p->neckTypes;
    d->neckHeights = p->necks[0];
    d->neckDistances = p->necks[1];
    d->neckScale = 0.8;
    d->neckCut = 0.3;
    p->standIn = (ctStandIn){randomReal(random, 0.3, 1.2), randomReal(random, 0.3, 1.2),
                             randomChance(random, 0.5) ? 0.05 : randomReal(random, 0.002, 0.2)};
}

/* Cutoffs as long as the stand-in's or longer, and a box for which they are short enough. */
static void drawBox(Program* p)
{
    const double cutoff = fmax(p->standIn.bornCutoff, p->standIn.pairCutoff) + randomReal(&p->random, 0, 0.5);
    p->born.cutoff = p->nonbonded.cutoff = cutoff;
    p->born.shift = 1 / cutoff;
    p->nonbonded.dielectric = 60;
    for (int k = 0; k < 3; k++) {
        p->box[k][k] = 2 * cutoff + (randomChance(&p->random, 0.5) ? 0.001 : randomReal(&p->random, 0, 4));
        for (int d = 0; d < k && randomChance(&p->random, 0.7); d++)
            p->box[k][d] = randomReal(&p->random, -0.5, 0.5) * p->box[d][d];
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
    } while (p->scene.particleCount > MOST_PARTICLES || p->scene.particleCount < 10);
    uint8_t listed[MOST_PARTICLES];
    memset(listed, 1, sizeof listed);
    memset(p->scene.radii, 0, (size_t)p->scene.particleCount * sizeof(double));
    ctDefinition scene = defineScene(&p->scene, listed);
    describe(p);
    p->isPeriodic = seed % 5 % 2 == 1;
    if (p->isPeriodic)
        drawBox(p);
    scene.box = p->isPeriodic ? (const double(*)[3])p->box : NULL;
    setStandInBox(scene.box);
    p->isFlexible = scene.isFlexible = seed % 2 == 0;
    p->tree = createDefined(&scene);
    p->definition =
        (ctEnergyDefinition){.scene = &scene, .nonbonded = &p->nonbonded, .born = &p->born, .standIn = &p->standIn};
    char text[200] = "";
    if (ctCreateEnergy(p->tree, &p->definition, &p->energy, text, sizeof text) != ctSuccess) {
        printf("seed %llu: %s\n", (unsigned long long)seed, text);
        exit(1);
    }
    ctSetStandIn(p->energy, p->far);
    /* 0.2 kJ/mol for two elementary charges. */
    if (isJudged && p->standIn.pairCutoff > 0.7 && !(findWorstShift(&p->definition) < 0.2L / 138.9L))
        fail(p, "the error at the cutoff", findWorstShift(&p->definition), 0);
}

static void answer(Program* p, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    p->answers = (p->answers ^ bits) * 0x100000001b3;
}

static StandInSum judge(Program* p)
{
    ctGetPositions(p->tree, p->positions);
    StandInSum sum = sumStandIn(&p->definition, p->scene.particleCount, p->positions, p->far);
    tally.ambiguous += sum.isAmbiguous;
    tally.compared += !sum.isAmbiguous;
    return sum;
}

/* Compares the energies that the stand-in stands for with sums over all pairs. */
static void compareWhole(Program* p)
{
    const WholeSum sum = sumWhole(&p->definition, p->scene.particleCount, p->positions);
    double nonbonded, born;
    if (ctComputeWholeEnergy(p->energy, &nonbonded, &born, NULL) != ctSuccess)
        fail(p, "a whole energy", 1, 0);
    if (!(fabsl(nonbonded - sum.nonbonded) <= 1e-6L * sum.size))
        fail(p, "Lennard-Jones and Coulomb", nonbonded, sum.nonbonded);
    if (!(fabsl(born - sum.born) <= 2e-6L * sum.size))
        fail(p, "the Born energy", born, sum.born);
}

/* Compares the stored energy with that of all pairs, and with a recomputed one. */
static void compareState(Program* p)
{
    const double kept = ctGetPairEnergy(p->energy);
    answer(p, kept);
    if (p->isJudged) {
        const StandInSum sum = judge(p);
        if (!sum.isAmbiguous && !(fabsl(kept - sum.energy) <= sum.doubt + 1e-6L))
            fail(p, "the energy of the state", kept, sum.energy);
        if (ctRefreshEnergy(p->energy, NULL) != ctSuccess)
            fail(p, "a refresh", 1, 0);
        const double fresh = ctGetPairEnergy(p->energy);
        if (!sum.isAmbiguous && !(fabsl(kept - fresh) <= sum.doubt + 1e-6L))
            fail(p, "the energy kept against a fresh one", kept, fresh);
        if (!sum.isAmbiguous && p->isPeriodic)
            compareWhole(p);
    }
    else if (ctRefreshEnergy(p->energy, NULL) != ctSuccess)
        fail(p, "a refresh", 1, 0);
}

enum { MOST_DISPLACED = 4 };

/* A change of a joint, or displacements. */
typedef struct Trial {
    ctChange change;
    int count; /* 0: the change */
    ctDisplacement displacements[MOST_DISPLACED];
} Trial;

/* Proposes a trial and computes all parts of its energy change; false if it cannot be proposed. */
static bool propose(Program* p, const Trial* trial, double parts[CT_ENERGY_PARTS], double* nearBack)
{
    if (trial->count > 0 ? ctProposeDisplacements(p->tree, trial->count, trial->displacements) != ctSuccess
                         : ctPropose(p->tree, 1, &trial->change) != ctSuccess)
        return false;
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
        if (ctComputeEnergyChange(p->energy, (ctEnergyPart)part, &parts[part], NULL) != ctSuccess)
            fail(p, "a change", 1, 0);
        answer(p, parts[part]);
    }
    *nearBack = ctGetNearChangeBack(p->energy);
    answer(p, *nearBack);
    return true;
}

static bool isSame(double a, double b)
{
    return !(fabs(a) < 1e4) || fabs(a - b) <= 2e-3 + 1e-4 * fabs(a);
}

/* Draws a change of a joint that is not fixed, and the way back; false if it is fixed. */
static bool drawChange(Program* p, ctChange* there, ctChange* back)
{
    const int link = randomInt(&p->random, p->scene.linkCount);
    *there = *back = (ctChange){.link = link};
    const double most = randomChance(&p->random, 0.7) ? 0.05 : 3;
    if (p->scene.linkJoints[link] == ctFixedJoint)
        return false;
    if (p->scene.linkJoints[link] == ctTorsionJoint) {
        there->angle = randomReal(&p->random, -most, most);
        back->angle = -there->angle;
        return true;
    }
    /* Far enough that leaves which touch each other part, or meet. */
    const double farthest = randomChance(&p->random, 0.3) ? 1.5 : 0.1;
    for (int d = 0; d < 3; d++) {
        there->translation[d] = randomReal(&p->random, -farthest, farthest);
        back->translation[d] = -there->translation[d];
        if (p->scene.linkJoints[link] == ctBallJoint) {
            there->rotation[d] = 5 * there->translation[d];
            back->rotation[d] = -there->rotation[d];
        }
    }
    return true;
}

/* Draws displacements of up to four particles, neighbours or any, some by one shift, and the way back. */
static void drawDisplacements(Program* p, Trial* there, Trial* back)
{
    const double farthest = randomChance(&p->random, 0.2) ? 0.5 : 0.02;
    const int first = randomInt(&p->random, p->scene.particleCount);
    const int step = randomChance(&p->random, 0.7) ? 1 : 7;
    const int most = 1 + randomInt(&p->random, MOST_DISPLACED);
    for (int i = 0; i < most; i++) {
        ctDisplacement* d = &there->displacements[there->count];
        d->particle = (first + i * step) % p->scene.particleCount;
        if (p->scene.linkJoints[p->scene.particleLinks[d->particle]] == ctFixedJoint)
            continue;
        back->displacements[there->count].particle = d->particle;
        for (int k = 0; k < 3; k++) {
            const double shift = randomReal(&p->random, -farthest, farthest);
            d->shift[k] = i % 2 == 1 && there->count > 0 ? there->displacements[0].shift[k] : shift;
            back->displacements[there->count].shift[k] = -d->shift[k];
        }
        back->count = ++there->count;
    }
}

/* A trial, accepted or not; if accepted, sometimes also the way back. */
static void tryOne(Program* p)
{
    Trial there = {.count = 0}, back = {.count = 0};
    if (p->isFlexible && randomChance(&p->random, 0.6))
        drawDisplacements(p, &there, &back);
    if (there.count == 0 && !drawChange(p, &there.change, &back.change))
        return;
    tally.displacements += there.count > 0;
    double parts[CT_ENERGY_PARTS], partsBack[CT_ENERGY_PARTS], nearBack, nearThere;
    const double before = ctGetPairEnergy(p->energy);
    if (!propose(p, &there, parts, &nearBack))
        return; /* its axis has no length */
    tally.trials++;
    if (randomChance(&p->random, 0.4)) {
        ctReject(p->tree);
        if (ctGetPairEnergy(p->energy) != before)
            fail(p, "the energy after a trial that was dropped", ctGetPairEnergy(p->energy), before);
        return;
    }
    if (ctAccept(p->tree, NULL) != ctSuccess || ctAcceptEnergyChange(p->energy) != ctSuccess)
        fail(p, "accepting", 1, 0);
    tally.accepted++;
    const double change = parts[ctNearPairsPart] + parts[ctOtherPairsPart];
    const double after = ctGetPairEnergy(p->energy);
    if (fabs(before) < 1e5 && !(fabs(after - before - change) <= 1e-6))
        fail(p, "the change", change, (long double)after - before);
    if (!randomChance(&p->random, 0.3) || !propose(p, &back, partsBack, &nearThere))
        return;
    tally.ways += 2;
    tally.otherWays += !isSame(nearBack, partsBack[ctNearPairsPart]) + !isSame(parts[ctNearPairsPart], nearThere);
    tally.bentBack += fabs(nearBack + parts[ctNearPairsPart]) > 1e-4;
    ctReject(p->tree);
}

/* Trials that are taken back leave no trace: the energy has its bits, and so has the change of another trial. */
static void takeBack(Program* p)
{
    double* state = malloc((size_t)ctGetStateSize(p->tree) * sizeof *state);
    double before[CT_ENERGY_PARTS], after[CT_ENERGY_PARTS], nearBefore, nearAfter;
    Trial turn = {.change = {.link = randomInt(&p->random, p->scene.linkCount)}};
    const int joint = p->scene.linkJoints[turn.change.link];
    if (joint == ctTorsionJoint)
        turn.change.angle = 0.3;
    else
        turn.change.translation[0] = 0.05;
    if (state == NULL)
        abort();
    const bool isTrial = joint != ctFixedJoint && propose(p, &turn, before, &nearBefore);
    ctReject(p->tree);
    ctGetState(p->tree, state);
    const double energy = ctGetPairEnergy(p->energy);
    if (ctSaveEnergy(p->energy) != ctSuccess)
        fail(p, "keeping", 1, 0);
    for (int n = 0; n < 6; n++)
        tryOne(p);
    if (ctSetState(p->tree, state) != ctSuccess || ctRestoreEnergy(p->energy) != ctSuccess ||
        !ctIsEnergyOfState(p->energy))
        fail(p, "taking back", 1, 0);
    if (ctGetPairEnergy(p->energy) != energy)
        fail(p, "the energy that was taken back to", ctGetPairEnergy(p->energy), energy);
    if (isTrial &&
        (!propose(p, &turn, after, &nearAfter) || memcmp(before, after, sizeof before) != 0 || nearBefore != nearAfter))
        fail(p, "a change after taking back", after[ctOtherPairsPart], before[ctOtherPairsPart]);
    ctReject(p->tree);
    free(state);
}

static uint64_t runProgram(uint64_t seed, const char* instructions, bool isJudged)
{
    static Program p;
    setenv("CHAINTREE_SIMD", instructions, 1);
    createProgram(&p, seed, isJudged);
    if (ctRefreshEnergy(p.energy, NULL) != ctSuccess)
        fail(&p, "a refresh", 1, 0);
    compareState(&p);
    for (int step = 0; step < 40; step++) {
        tryOne(&p);
        if (step % 10 == 9)
            compareState(&p);
        if (step % 10 == 4)
            takeBack(&p);
    }
    ctDestroyEnergy(p.energy);
    ctDestroy(p.tree);
    randomSceneDestroy(&p.scene);
    tally.programs++;
    return p.answers;
}

int main(int argumentCount, char** arguments)
{
    const int programs = argumentCount > 1 ? atoi(arguments[1]) : defaultProgramCount;
    uint64_t seed = argumentCount > 2 ? strtoull(arguments[2], NULL, 10) : defaultSeed;
    for (int n = 0; n < programs; n++, seed++) {
        const uint64_t widest = runProgram(seed, "avx512", true);
        if (runProgram(seed, "avx2", false) != widest || runProgram(seed, "portable", false) != widest) {
            printf("seed %llu: instruction sets give other bits\n", (unsigned long long)seed);
            return 1;
        }
    }
    printf("%ld programs, %ld trials, %ld of displaced particles, %ld accepted, %ld states compared, %ld ambiguous, "
           "near pairs of %ld not the "
           "opposite on the way back, %ld of %ld ways doubtful\n",
           tally.programs, tally.trials, tally.displacements, tally.accepted, tally.compared, tally.ambiguous,
           tally.bentBack, tally.otherWays, tally.ways);
    /* Back and forth leaves roundings, by which a radius can fall to another one of the grid: in some 2 %, but those of
     * a scene are alike. */
    if (tally.otherWays > 3 + tally.ways / 25) {
        printf("near pairs of %ld ways of %ld change otherwise than those back\n", tally.otherWays, tally.ways);
        return 1;
    }
    return programs < 20 || (tally.compared > 50 && tally.bentBack > 5 && tally.displacements > tally.trials / 5) ? 0
                                                                                                                  : 1;
}
