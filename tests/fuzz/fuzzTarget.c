#include "fuzzTarget.h"

#include "programs/operations.h"

#include <stdio.h>
#include <stdlib.h>

/* The oracle compares all pairs, and slow programs find little: limit their size. */
static const int mostParticles = 250;
static const int mostOperations = 1000;

static Tally tally;

static void printFuzzed(void)
{
    printTally(&tally);
}

int LLVMFuzzerInitialize(int* argumentCount, char*** arguments)
{
    (void)argumentCount;
    (void)arguments;
    return atexit(printFuzzed);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count)
{
    randomSource chosen = randomSourceFromBytes(count, bytes);
    /* Half of the scenes come from a seed, which leaves nearly all bytes for the operations. */
    randomSource seeded = randomSourceFromSeed((uint64_t)randomInt(&chosen, 1 << 16));
    randomScene scene;
    randomSceneCreate(&scene, randomChance(&chosen, 0.5) ? &seeded : &chosen);
    if (scene.particleCount > mostParticles) {
        randomSceneDestroy(&scene);
        return 0;
    }
    Program program;
    programCreate(&program, "this input", scene, chosen, true, &tally);
    runOperations(&program, mostOperations);
    programDestroy(&program);
    return 0;
}
