/* Random programs, run on the engine and on the oracle.
 *
 * Usage: TestRandomPrograms [operations] [seed] [particles]. Programs have the seeds that follow; those on scenes of
 * more particles are passed over (most of the time goes into a few large ones). A failure prints its seed, so that
 * "TestRandomPrograms 1 SEED" runs that program alone.
 */
#include "programs/operations.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

static const long defaultOperationCount = 75000;
static const uint64_t defaultSeed = 20020607;

static int runProgram(uint64_t seed, int mostParticles, Tally* tally)
{
    char name[40];
    snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
    randomSource random = randomSourceFromSeed(seed);
    randomScene scene;
    randomSceneCreate(&scene, &random);
    int steps = 20 + randomInt(&random, 200);
    if (scene.particleCount > mostParticles) {
        randomSceneDestroy(&scene);
        return 0;
    }
    Program program;
    programCreate(&program, name, scene, random, false, tally);
    runOperations(&program, steps);
    programDestroy(&program);
    return steps;
}

int main(int argumentCount, char** arguments)
{
    long wanted = argumentCount > 1 ? atol(arguments[1]) : defaultOperationCount;
    uint64_t seed = argumentCount > 2 ? strtoull(arguments[2], NULL, 10) : defaultSeed;
    int mostParticles = argumentCount > 3 ? atoi(arguments[3]) : INT_MAX;
    Tally tally = {0};
    long done = 0;
    while (done < wanted)
        done += runProgram(seed++, mostParticles, &tally);
    printTally(&tally);
    return 0;
}
