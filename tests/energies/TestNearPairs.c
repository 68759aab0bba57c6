/* Delayed acceptance is exact only if the way back is judged by the same stages: the near pairs of a trial must change
 * by the opposite of what those of its inverse change by, and so must the others. In random scenes. */
#include "ctenergy.h"
#include "oracle/randomScene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCENES = 60, TRIALS = 60, MOST_PARTICLES = 400 };

typedef struct Bench {
    randomScene scene;
    ctChainTree* tree;
    ctEnergy* energy;
    double charges[MOST_PARTICLES];
    double sigmas[MOST_PARTICLES];
    double epsilons[MOST_PARTICLES];
    double positions[3 * MOST_PARTICLES];
} Bench;

static long both = 0; /* trials that changed near pairs and others */

static void require(bool condition, const char* what, int scene)
{
    if (!condition) {
        printf("scene %d: %s\n", scene, what);
        exit(1);
    }
}

static void makeBench(Bench* b, randomSource* random, int number)
{
    memset(b, 0, sizeof *b);
    do {
        randomSceneDestroy(&b->scene);
        randomSceneCreate(&b->scene, random);
    } while (b->scene.particleCount > MOST_PARTICLES || b->scene.particleCount < 40);
    randomScene* s = &b->scene;
    static uint8_t listed[MOST_PARTICLES];
    memset(listed, 1, sizeof listed);
    memset(s->radii, 0, (size_t)s->particleCount * sizeof(double));
    for (int i = 0; i < s->particleCount; i++) {
        b->charges[i] = randomReal(random, -1, 1);
        b->sigmas[i] = 0.01;
        b->epsilons[i] = 0.001;
    }
    const ctDefinition definition = {.particleCount = s->particleCount,
                                     .positions = s->positions,
                                     .radii = s->radii,
                                     .hydrogenBondRoles = s->roles,
                                     .particleLinks = s->particleLinks,
                                     .listed = listed,
                                     .linkCount = s->linkCount,
                                     .linkParents = s->linkParents,
                                     .linkJoints = s->linkJoints,
                                     .linkTorsions = (const int(*)[4])s->linkTorsions,
                                     .overlapTolerance = s->overlapTolerance};
    const ctNonbonded nonbonded = {.charges = b->charges,
                                   .sigmas = b->sigmas,
                                   .epsilons = b->epsilons,
                                   .cutoff = number % 2 == 0 ? INFINITY : 1.2,
                                   .switchingDistance = INFINITY,
                                   .dielectric = 1};
    const ctEnergyDefinition energy = {.scene = &definition, .nonbonded = &nonbonded};
    require(ctCreate(&definition, &b->tree, NULL, 0) == ctSuccess, "no scene", number);
    require(ctCreateEnergy(b->tree, &energy, &b->energy, NULL, 0) == ctSuccess, "no energy", number);
}

/* Makes a trial of a change and the state of the trial. */
static void go(Bench* b, const ctChange* change, double changes[CT_ENERGY_PARTS], int number)
{
    require(ctPropose(b->tree, 1, change) == ctSuccess, "no trial", number);
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
        require(ctComputeEnergyChange(b->energy, (ctEnergyPart)part, &changes[part], NULL) == ctSuccess, "no change",
                number);
    }
    require(ctAccept(b->tree, NULL) == ctSuccess, "not accepted", number);
    require(ctAcceptEnergyChange(b->energy) == ctSuccess, "not accepted", number);
}

static void runBench(Bench* b, randomSource* random, int number)
{
    require(ctRefreshEnergy(b->energy, NULL) == ctSuccess, "no refresh", number);
    for (int trial = 0; trial < TRIALS; trial++) {
        ctChange there = {.link = randomInt(random, b->scene.linkCount)};
        if (b->scene.linkJoints[there.link] == ctFixedJoint)
            continue;
        const double most = trial % 2 == 0 ? 0.05 : 3;
        ctChange back = there;
        if (b->scene.linkJoints[there.link] == ctTorsionJoint) {
            there.angle = randomReal(random, -most, most);
            back.angle = -there.angle;
        }
        else {
            for (int d = 0; d < 3; d++) {
                there.rotation[d] = randomReal(random, -most / 2, most / 2);
                there.translation[d] = randomReal(random, -0.1, 0.1);
                there.pivot[d] = b->scene.positions[d];
                back.rotation[d] = -there.rotation[d];
                back.translation[d] = -there.translation[d];
                back.pivot[d] = there.pivot[d] + there.translation[d];
            }
        }
        if (ctPropose(b->tree, 1, &there) != ctSuccess)
            continue; /* its axis has no length */
        ctReject(b->tree);
        double forward[CT_ENERGY_PARTS];
        double backward[CT_ENERGY_PARTS];
        go(b, &there, forward, number);
        go(b, &back, backward, number);
        for (int part = 0; part < CT_ENERGY_PARTS; part++) {
            /* Where particles overlap, roundings of their places matter. */
            const double tolerance = 1e-3 + 1e-4 * fabs(forward[part]);
            if (fabs(forward[part]) < 1e6 && !(fabs(forward[part] + backward[part]) <= tolerance)) {
                printf("scene %d, trial %d, part %d: there %.9g, back %.9g\n", number, trial, part, forward[part],
                       backward[part]);
                exit(1);
            }
        }
        both += forward[ctNearPairsPart] != 0 && forward[ctOtherPairsPart] != 0;
    }
}

int main(void)
{
    static Bench bench;
    randomSource random = randomSourceFromSeed(1603);
    for (int number = 0; number < SCENES; number++) {
        makeBench(&bench, &random, number);
        runBench(&bench, &random, number);
        ctDestroyEnergy(bench.energy);
        ctDestroy(bench.tree);
        randomSceneDestroy(&bench.scene);
        memset(&bench.scene, 0, sizeof bench.scene);
    }
    printf("%ld trials changed near pairs and others\n", both);
    return both > 100 ? 0 : 1;
}
