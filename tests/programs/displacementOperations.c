#include "operations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* nm: displacements shorten no axis below this, since turns about it are as exact as its direction. */
#define LEAST_AXIS 0.02

/* ---- Choose ---- */

static bool isFixed(const Program* p, int particle)
{
    return p->scene.linkJoints[p->scene.particleLinks[particle]] == ctFixedJoint;
}

/* A particle, often of a torsion, often near another in the numbering; or a fixed one. */
static int chooseDisplaced(Program* p, int before)
{
    const double kind = randomReal(&p->random, 0, 1);
    const int link = randomInt(&p->random, p->scene.linkCount);
    if (kind < 0.3 && p->scene.linkJoints[link] == ctTorsionJoint)
        return p->scene.linkTorsions[4 * link + randomInt(&p->random, 4)];
    if (kind < 0.4 && p->scene.linkJoints[link] == ctBallJoint)
        return p->scene.linkTorsions[4 * link + 1];
    if (kind < 0.7 && before != CT_NULL)
        return (before + 1) % p->scene.particleCount;
    return chooseParticle(p);
}

static void chooseShift(Program* p, int particle, double shift[3])
{
    const double kind = randomReal(&p->random, 0, 1);
    double size = randomReal(&p->random, 0.001, 0.2);
    if (kind < 0.05)
        size = 0;
    else if (kind < 0.15)
        size = pow(10, randomReal(&p->random, -16, -3));
    else if (kind < 0.2)
        size = randomReal(&p->random, 0.2, 5);
    randomDirection(&p->random, shift);
    const int other = kind > 0.9 ? chooseParticle(p) : particle;
    for (int axis = 0; axis < 3; axis++) {
        shift[axis] = size * shift[axis] + p->state[3 * other + axis] - p->state[3 * particle + axis];
        shift[axis] = shift[axis] == 0 ? 0 : shift[axis]; /* without a sign */
    }
}

/* Whether all axes on which a particle lies are long enough in the oracle's trial. */
static bool keepsAxes(const Program* p, int particle)
{
    for (int link = 0; link < p->scene.linkCount; link++) {
        const int* torsion = p->scene.linkTorsions + 4 * link;
        if (p->scene.linkJoints[link] == ctTorsionJoint && (torsion[1] == particle || torsion[2] == particle) &&
            oracleDistance(p->oracle, ORACLE_TRIAL, torsion[1], torsion[2]) < LEAST_AXIS)
            return false;
    }
    return true;
}

static int chooseDisplacementCount(Program* p)
{
    const int most = p->scene.particleCount < 200 ? p->scene.particleCount : 200;
    const int count = randomChance(&p->random, 0.02) ? most : 1 + randomInt(&p->random, 4);
    return count < most ? count : most;
}

/* Chooses particles that are not fixed, each once, and shifts, of which some are equal. */
static int chooseDisplacements(Program* p, int count, int* particles, double* shifts)
{
    int chosen = 0;
    memset(p->isDisplaced, 0, (size_t)p->scene.particleCount * sizeof(bool));
    for (int n = 0; n < count; n++) {
        const int particle = chooseDisplaced(p, chosen > 0 ? particles[chosen - 1] : CT_NULL);
        const bool isAsBefore = randomChance(&p->random, 0.5);
        if (isFixed(p, particle) || p->isDisplaced[particle])
            continue;
        p->isDisplaced[particle] = true;
        particles[chosen] = particle;
        if (chosen > 0 && isAsBefore)
            memcpy(shifts + 3 * chosen, shifts + 3 * chosen - 3, sizeof(double[3]));
        else
            chooseShift(p, particle, shifts + 3 * chosen);
        chosen++;
    }
    return chosen;
}

/* Sets shifts that shorten axes too much to 0. */
static void restrictShifts(Program* p, int count, const int* particles, double* shifts)
{
    oracleProposeDisplacements(p->oracle, count, particles, shifts);
    for (int n = 0; n < count; n++)
        if (!keepsAxes(p, particles[n])) {
            memset(shifts, 0, 3 * (size_t)count * sizeof(double));
            oracleProposeDisplacements(p->oracle, count, particles, shifts);
            return;
        }
}

/* ---- Propose ---- */

void openDisplacements(Program* p, int count, const int* particles, const double* shifts)
{
    ctDisplacement* displacements = programAllocate(count, sizeof(ctDisplacement));
    memset(p->isInTrial, 0, (size_t)p->scene.linkCount * sizeof(bool));
    memset(p->isDisplaced, 0, (size_t)p->scene.particleCount * sizeof(bool));
    for (int n = 0; n < count; n++) {
        displacements[n].particle = particles[n];
        memcpy(displacements[n].shift, shifts + 3 * n, sizeof displacements[n].shift);
        p->isInTrial[p->roots[p->scene.particleLinks[particles[n]]]] = true;
        p->isDisplaced[particles[n]] = true;
    }
    SUCCEED(ctProposeDisplacements(p->tree, count, displacements));
    oracleProposeDisplacements(p->oracle, count, particles, shifts);
    p->displaces = true;
    free(displacements);
}

int proposeDisplacements(Program* p)
{
    int count = chooseDisplacementCount(p);
    int* particles = programAllocate(count, sizeof(int));
    double* shifts = programAllocate(3 * count, sizeof(double));
    count = chooseDisplacements(p, count, particles, shifts);
    restrictShifts(p, count, particles, shifts);
    if (count > 0)
        openDisplacements(p, count, particles, shifts);
    else {
        SUCCEED(ctPropose(p->tree, 0, NULL));
        p->displaces = false;
    }
    free(shifts);
    free(particles);
    return count;
}

void requireTrialParticles(const Program* p)
{
    const int *particles, *links;
    const int count = ctGetTrialParticles(p->tree, &particles);
    int displaced = 0;
    for (int i = 0; i < p->scene.particleCount && p->displaces; i++)
        displaced += p->isDisplaced[i];
    require(count == displaced, p, "the trial displaces %d particles, not %d", count, displaced);
    for (int n = 0; n < count; n++)
        require(p->isDisplaced[particles[n]], p, "the trial displaces particle %d", particles[n]);
    require(count == 0 || ctGetTrialLinks(p->tree, &links) == 0, p, "displacements change links");
}

/* ---- Accept ---- */

static void getOrientations(const Program* p, double* rotations)
{
    ctGetOrientations(p->tree, (double(*)[9])rotations);
}

void acceptDisplacements(Program* p, ctCounts* counts)
{
    const int last = p->scene.linkCount - 1;
    const size_t size = 9 * (size_t)p->scene.linkCount * sizeof(double);
    double* before = programAllocate(9 * p->scene.linkCount, sizeof(double));
    double* after = programAllocate(9 * p->scene.linkCount, sizeof(double));
    ctTransform transformBefore, transformAfter;
    getOrientations(p, before);
    SUCCEED(ctGetRelativeTransform(p->tree, 0, last, &transformBefore));
    SUCCEED(ctAccept(p->tree, counts));
    getOrientations(p, after);
    SUCCEED(ctGetRelativeTransform(p->tree, 0, last, &transformAfter));
    require(memcmp(before, after, size) == 0, p, "displacements turn a link");
    require(memcmp(&transformBefore, &transformAfter, sizeof transformBefore) == 0, p, "displacements move a link");
    for (int i = 0; i < p->scene.particleCount; i++)
        require(p->isDisplaced[i] || memcmp(p->trial + 3 * i, p->state + 3 * i, sizeof(double[3])) == 0, p,
                "particle %d is not displaced and has moved", i);
    p->tally->displaced++;
    free(before);
    free(after);
}

/* ---- Refused ---- */

ctDisplacement chooseDisplacement(Program* p)
{
    ctDisplacement displacement = {.particle = chooseParticle(p)};
    for (int tries = 0; tries < 20 && isFixed(p, displacement.particle); tries++)
        displacement.particle = chooseParticle(p);
    chooseShift(p, displacement.particle, displacement.shift);
    return displacement;
}

static void refuse(Program* p, int count, const ctDisplacement* displacements)
{
    FAIL(ctInvalidArgument, ctProposeDisplacements(p->tree, count, displacements));
}

void displaceNonsense(Program* p)
{
    ctDisplacement displacements[3] = {{0}};
    if (!p->scene.isFlexible) {
        refuse(p, 1, displacements);
        return;
    }
    for (int n = 0; n < 3; n++)
        displacements[n] = chooseDisplacement(p);
    displacements[2].particle = displacements[randomInt(&p->random, 2)].particle;
    refuse(p, 3, displacements);
    refuse(p, 0, displacements);
    refuse(p, -1, displacements);
    refuse(p, p->scene.particleCount + 1, displacements);
    refuse(p, 1, NULL);
    const int nowhere[] = {-1, p->scene.particleCount};
    for (int n = 0; n < 2; n++) {
        const ctDisplacement bad = {.particle = nowhere[n]};
        refuse(p, 1, &bad);
    }
    for (int i = 0; i < p->scene.particleCount; i++) {
        const ctDisplacement fixed = {.particle = i, .shift = {0.1}};
        if (isFixed(p, i))
            refuse(p, 1, &fixed);
    }
    displacements[0].shift[randomInt(&p->random, 3)] = chooseNoLength(p);
    refuse(p, 1, displacements);
}
