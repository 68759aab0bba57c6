/* Random programs, run on the engine and on the oracle.
 *
 * Usage: TestRandomPrograms [operations] [seed]. Programs have the seeds that follow. A failure prints its own, so that
 * "TestRandomPrograms 1 SEED" runs that program alone.
 */
#include "programs/operations.h"

#include <stdio.h>
#include <stdlib.h>

static const long defaultOperationCount = 300000;
static const uint64_t defaultSeed = 20020607;

typedef struct Operation {
    const char* name;
    double weight;
    void (*run)(Program* program);
    long count;
} Operation;

static Operation operations[] = {
    {"propose", 20, propose, 0},
    {"verdict", 14, compareVerdicts, 0},
    {"changed pairs", 8, compareChangedPairs, 0},
    {"commit", 8, commit, 0},
    {"commit and compare lists", 3, commitAndCompareLists, 0},
    {"commit and raise limits", 3, commitAndRaiseLimits, 0},
    {"discard", 5, discard, 0},
    {"set limits", 1.5, setLimits, 0},
    {"raise limits", 1, raiseLimits, 0},
    {"set positions", 1, setPositions, 0},
    {"set state", 1, setState, 0},
    {"positions", 3, comparePositions, 0},
    {"torsion angle", 5, compareTorsionAngle, 0},
    {"relative transform", 5, compareRelativeTransform, 0},
    {"centroid", 2, compareCentroid, 0},
    {"validate", 2, validate, 0},
    {"clashes", 6, compareClashes, 0},
    {"neighbour pairs", 6, compareNeighborPairs, 0},
    {"probe", 3, compareProbe, 0},
    {"minimum distance", 3, compareMinimumDistance, 0},
    {"energy", 4, compareEnergy, 0},
    {"lists ended early", 1, endListsEarly, 0},
    {"calls without a trial", 1, callWithoutTrial, 0},
    {"nonsense proposed", 1, proposeNonsense, 0},
    {"nonsense asked", 1, queryNonsense, 0},
    {"nonsense set", 1, setNonsense, 0},
};

enum { OPERATIONS = sizeof operations / sizeof operations[0] };

static Operation* chooseOperation(randomSource* random)
{
    double total = 0;
    for (int n = 0; n < OPERATIONS; n++)
        total += operations[n].weight;
    double left = randomReal(random, 0, total);
    int chosen = 0;
    while (chosen < OPERATIONS - 1 && left >= operations[chosen].weight)
        left -= operations[chosen++].weight;
    return operations + chosen;
}

static int runProgram(uint64_t seed, Tally* tally)
{
    Program program;
    programCreate(&program, seed, tally);
    int steps = 20 + randomInt(&program.random, 200);
    for (program.step = 1; program.step <= steps; program.step++) {
        Operation* operation = chooseOperation(&program.random);
        program.operation = operation->name;
        operation->run(&program);
        operation->count++;
    }
    programDestroy(&program);
    return steps;
}

int main(int argumentCount, char** arguments)
{
    long wanted = argumentCount > 1 ? atol(arguments[1]) : defaultOperationCount;
    uint64_t seed = argumentCount > 2 ? strtoull(arguments[2], NULL, 10) : defaultSeed;
    Tally tally = {0};
    long done = 0;
    while (done < wanted)
        done += runProgram(seed++, &tally);
    printf("%ld operations on %ld scenes of up to %d particles\n", done, tally.programs, tally.largest);
    printf("verdicts: %ld clashing, %ld clash-free, of which %ld within CT_SIGMA of a limit\n", tally.clashing,
           tally.clashFree, tally.doubtful);
    printf("pairs: %ld clashes, %ld neighbours, %ld changed, %ld limits raised\n", tally.clashes, tally.neighbors,
           tally.changed, tally.raised);
    for (int n = 0; n < OPERATIONS; n++)
        printf("%8ld %s\n", operations[n].count, operations[n].name);
    return 0;
}
