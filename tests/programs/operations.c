#include "operations.h"

#include <stdio.h>

typedef struct Operation {
    const char* name;
    double weight;
    void (*run)(Program* program);
} Operation;

static const Operation operations[] = {
    {"propose", 20, propose},
    {"verdict", 14, compareVerdicts},
    {"changed pairs", 8, compareChangedPairs},
    {"accept", 8, acceptTrial},
    {"accept and compare lists", 3, acceptAndCompareLists},
    {"accept and raise limits", 3, acceptAndRaiseLimits},
    {"reject", 5, rejectTrial},
    {"set limits", 1.5, setLimits},
    {"raise limits", 1, raiseLimits},
    {"set positions", 1, setPositions},
    {"set state", 1, setState},
    {"positions", 3, comparePositions},
    {"torsion angle", 5, compareTorsionAngle},
    {"relative transform", 5, compareRelativeTransform},
    {"centroid", 2, compareCentroid},
    {"validate", 2, validate},
    {"clashes", 6, compareClashes},
    {"neighbour pairs", 6, compareNeighborPairs},
    {"probe", 3, compareProbe},
    {"minimum distance", 3, compareMinimumDistance},
    {"energy", 4, compareEnergy},
    {"lists ended early", 1, endListsEarly},
    {"calls without a trial", 1, callWithoutTrial},
    {"nonsense proposed", 1, proposeNonsense},
    {"nonsense asked", 1, queryNonsense},
    {"nonsense set", 1, setNonsense},
    {"nonsense made", 0.5, createNonsense},
    {"extremes", 0.5, goToExtremes},
};

_Static_assert(sizeof operations / sizeof operations[0] == OPERATION_KINDS, "a tally has room for all kinds");

static int chooseOperation(randomSource* random)
{
    double total = 0;
    for (int n = 0; n < OPERATION_KINDS; n++)
        total += operations[n].weight;
    double left = randomReal(random, 0, total);
    int chosen = 0;
    while (chosen < OPERATION_KINDS - 1 && left >= operations[chosen].weight)
        left -= operations[chosen++].weight;
    return chosen;
}

int runOperations(Program* p, int most)
{
    int done = 0;
    for (; done < most && !randomIsUsedUp(&p->random); done++) {
        const int kind = chooseOperation(&p->random);
        p->step++;
        p->operation = operations[kind].name;
        operations[kind].run(p);
        p->tally->operations[kind]++;
    }
    return done;
}

void printTally(const Tally* tally)
{
    long all = 0;
    for (int n = 0; n < OPERATION_KINDS; n++)
        all += tally->operations[n];
    printf("%ld operations on %ld scenes of up to %d particles\n", all, tally->programs, tally->largest);
    printf("verdicts: %ld clashing, %ld clash-free, of which %ld within CT_SIGMA of a limit\n", tally->clashing,
           tally->clashFree, tally->doubtful);
    printf("pairs: %ld clashes, %ld neighbours, %ld changed, %ld limits raised\n", tally->clashes, tally->neighbors,
           tally->changed, tally->raised);
    printf("trials: %ld accepted displacements\n", tally->displaced);
    for (int n = 0; n < OPERATION_KINDS; n++)
        printf("%8ld %s\n", tally->operations[n], operations[n].name);
}
