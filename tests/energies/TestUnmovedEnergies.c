/* Energies beside closed windows: what lies behind one counts as unmoved, so what is kept of it lags behind the state,
 * by little: against energies recomputed in a scene with the same state. */
#include "ctenergy.h"
#include "sceneDefinition.h"
#include "windows/closedWindow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINKS = 90, PARTICLES = SIDE * LINKS, KINDS = 3, COLUMNS = 7, SPRINGS = 200, WINDOW = 9 };

typedef struct Bench {
    const char* name;
    randomSource random;
    randomScene scene;
    ctDefinition definition;
    ctEnergyDefinition energies;
    ctTermSet terms[2];
    int springs[SPRINGS][2];
    int dihedrals[LINKS][4];
    double numbers[SPRINGS][2];
    double columns[COLUMNS][PARTICLES];
    ctNonbonded nonbonded;
    ctBorn born;
    ctStandIn standIn;
    ctChainTree* tree;
    ctEnergy* energy;
    double positions[3 * PARTICLES];
} Bench;

static void require(bool condition, const Bench* b, const char* what, double value)
{
    if (!condition) {
        printf("%s: %s (%.12g)\n", b->name, what, value);
        exit(1);
    }
}

static const double* column(Bench* b, int number, double low, double high)
{
    for (int i = 0; i < PARTICLES; i++)
        b->columns[number][i] = randomReal(&b->random, low, high);
    return b->columns[number];
}

static void describeTerms(Bench* b)
{
    for (int n = 0; n < SPRINGS; n++) {
        b->springs[n][0] = randomInt(&b->random, PARTICLES);
        b->springs[n][1] = (b->springs[n][0] + 1 + randomInt(&b->random, PARTICLES - 1)) % PARTICLES;
        b->numbers[n][0] = 0.5;
        b->numbers[n][1] = 100;
    }
    for (int link = 0; link < LINKS; link++)
        memcpy(b->dihedrals[link], b->scene.linkTorsions + 4 * (link > 0 ? link : 1), sizeof b->dihedrals[link]);
    static double torsions[LINKS][3];
    for (int link = 0; link < LINKS; link++) {
        torsions[link][0] = 3;
        torsions[link][2] = 5;
    }
    b->terms[0] = (ctTermSet){.kind = ctHarmonicBondTerm,
                              .count = SPRINGS,
                              .particlesPerTerm = 2,
                              .particles = b->springs[0],
                              .parametersPerTerm = 2,
                              .parameters = b->numbers[0]};
    b->terms[1] = (ctTermSet){.kind = ctPeriodicTorsionTerm,
                              .count = LINKS,
                              .particlesPerTerm = 4,
                              .particles = b->dihedrals[0],
                              .parametersPerTerm = 3,
                              .parameters = torsions[0]};
}

/* With a cutoff, without one, and with a stand-in for Born solvation. */
static void createBench(Bench* b, int kind, uint64_t seed)
{
    static const char* const names[KINDS] = {"cutoff", "no cutoff", "stand-in"};
    static uint8_t listed[PARTICLES];
    memset(b, 0, sizeof *b);
    b->name = names[kind];
    b->random = randomSourceFromSeed(seed);
    b->scene = makeChainScene(&b->random, LINKS);
    memset(listed, 1, sizeof listed);
    for (int i = 0; i < PARTICLES; i += 7) /* some are listed, and not modelled */
        b->scene.radii[i] = 0;
    b->definition = defineScene(&b->scene, listed);
    describeTerms(b);
    b->nonbonded = (ctNonbonded){.charges = column(b, 0, -0.3, 0.3),
                                 .sigmas = column(b, 1, 0.05, 0.1),
                                 .epsilons = column(b, 2, 0, 0.5),
                                 .cutoff = kind == 0 ? 0.9 : INFINITY,
                                 .switchingDistance = INFINITY,
                                 .dielectric = 78.5,
                                 .exclusionCount = b->scene.exclusionCount,
                                 .exclusions = (const int(*)[2])b->scene.exclusions};
    b->born = (ctBorn){.charges = b->columns[0],
                       .radii = column(b, 3, 0.14, 0.18),
                       .offsetRadii = column(b, 4, 0.12, 0.13),
                       .scaledRadii = column(b, 5, 0.01, 0.03),
                       .coulomb = CT_COULOMB,
                       .soluteDielectric = 1,
                       .solventDielectric = 78.5,
                       .cutoff = INFINITY};
    b->standIn = (ctStandIn){0.8, 0.9, 0.05};
    b->energies = (ctEnergyDefinition){
        .scene = &b->definition, .nonbonded = &b->nonbonded, .termSetCount = 2, .termSets = b->terms};
    if (kind == 2) {
        b->energies.born = &b->born;
        b->energies.standIn = &b->standIn;
    }
    b->tree = createDefined(&b->definition);
    char text[200] = "";
    const ctStatus status = ctCreateEnergy(b->tree, &b->energies, &b->energy, text, sizeof text);
    require(status == ctSuccess, b, text, status);
    require(ctRefreshEnergy(b->energy, NULL) == ctSuccess, b, "no refresh", 0);
}

static void destroyBench(Bench* b)
{
    ctDestroyEnergy(b->energy);
    ctDestroy(b->tree);
    randomSceneDestroy(&b->scene);
}

static double wholeEnergy(const ctEnergy* energy)
{
    return ctGetPairEnergy(energy) + ctGetTermEnergy(energy, 0) + ctGetTermEnergy(energy, 1);
}

/* The energy of the state, recomputed in its own scene. */
static double freshEnergy(const Bench* b)
{
    ctChainTree* tree = createDefined(&b->definition);
    double* state = malloc(ctGetStateSize(tree) * sizeof(double));
    ctEnergy* energy;
    ctGetState(b->tree, state);
    require(ctSetState(tree, state) == ctSuccess, b, "the state is refused", 0);
    require(ctCreateEnergy(tree, &b->energies, &energy, NULL, 0) == ctSuccess, b, "no energy", 0);
    require(ctRefreshEnergy(energy, NULL) == ctSuccess, b, "no refresh", 0);
    const double sum = wholeEnergy(energy);
    ctDestroyEnergy(energy);
    ctDestroy(tree);
    free(state);
    return sum;
}

/* Opens a trial of a window that closes up to a shift, or of one torsion. False if it does not close. */
static bool propose(Bench* b, bool isWindow, double length)
{
    ctChange changes[WINDOW] = {0};
    int count = 1;
    changes[0] = (ctChange){.link = 1 + randomInt(&b->random, LINKS - 1), .angle = randomReal(&b->random, -0.05, 0.05)};
    if (isWindow) {
        const int link = 1 + randomInt(&b->random, LINKS - WINDOW - 1);
        const double shift[3] = {length, 0, 0};
        double angles[WINDOW];
        ctGetPositions(b->tree, b->positions);
        const Window window = readWindow(b->positions, link, WINDOW);
        for (int i = 0; i < WINDOW - 6; i++)
            angles[i] = randomReal(&b->random, -0.1, 0.1);
        if (!closeWindow(&window, shift, angles))
            return false;
        count = WINDOW;
        for (int i = 0; i < WINDOW; i++)
            changes[i] = (ctChange){.link = link + i, .angle = angles[i]};
    }
    require(ctPropose(b->tree, count, changes) == ctSuccess, b, "no trial", count);
    return true;
}

/* The change of the whole, part by part. */
static double computeChange(Bench* b)
{
    double sum = 0;
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
        double change;
        require(ctComputeEnergyChange(b->energy, (ctEnergyPart)part, &change, NULL) == ctSuccess, b, "no change", part);
        sum += change;
    }
    return sum;
}

/* Trials, of which those are accepted that change the energy by little; windows may leave a shift. */
static void run(Bench* b, int trials, double windows, double shift)
{
    double kept = wholeEnergy(b->energy);
    double shiftThen = ctGetTotalShift(b->tree);
    int accepted = 0, renewed = 0;
    for (int trial = 0; trial < trials; trial++) {
        if (!propose(b, randomChance(&b->random, windows), shift))
            continue;
        const double change = computeChange(b);
        if (!(change < 20)) {
            ctReject(b->tree);
            continue;
        }
        require(ctAccept(b->tree, NULL) == ctSuccess, b, "not accepted", trial);
        require(ctAcceptEnergyChange(b->energy) == ctSuccess, b, "not accepted", trial);
        accepted++;
        const double now = wholeEnergy(b->energy);
        require(fabs(now - kept - change) <= 1e-3 + 1e-7 * fabs(now), b, "the change is another", now - kept - change);
        kept = now;
        if (ctGetTotalShift(b->tree) - shiftThen > CT_MOST_LAG) {
            const double fresh = freshEnergy(b);
            require(memcmp(&now, &fresh, sizeof now) == 0, b, "no energy was recomputed", now - fresh);
            shiftThen = ctGetTotalShift(b->tree);
            renewed++;
        }
        else if (accepted % 10 == 0) {
            const double error = now - freshEnergy(b);
            require(fabs(now) > 1e5 || fabs(error) <= 1e-3 + 1e-5 * fabs(now), b, "the energy is another", error);
            require(ctValidate(b->tree), b, "ctValidate", trial);
        }
    }
    require(accepted > trials / 4, b, "too few trials are accepted", accepted);
    require(shift == 0 || renewed > 0, b, "no energy was ever recomputed", renewed);
}

int main(int argumentCount, char** arguments)
{
    const int rounds = argumentCount > 1 ? atoi(arguments[1]) : 3;
    for (int n = 0; n < rounds * KINDS; n++) {
        static Bench bench;
        createBench(&bench, n % KINDS, 20040229 + (uint64_t)n);
        run(&bench, 150, 0.75, 0);
        run(&bench, 500, 1, 5e-12);
        destroyBench(&bench);
    }
    return 0;
}
