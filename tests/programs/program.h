/* program.h: a random program: a scene, once in the engine and once in the oracle, and random calls on both.
 *
 * The oracle goes its own way in long double and never sees the engine's positions. Every answer is compared, exactly
 * but within CT_SIGMA of a limit, where only agreement of the engine with itself is asked for.
 */
#ifndef PROGRAM_H_
#define PROGRAM_H_

#include "chaintree.h"
#include "oracle/oracle.h"
#include "oracle/randomScene.h"
#include "pairs.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Within this of a limit either answer is right. Raised limits lie CT_SIGMA above their overlap: not so near. */
#define DOUBT (0.99 * CT_SIGMA)

/* nm: a pair whose distance a trial changes by no more may be listed as changed or not. */
#define COUNTS_AS_UNMOVED 2.1e-11

#define PI 3.14159265358979323846

enum { OPERATION_KINDS = 28 };

/* Counts of events in all programs, which show that comparisons were not empty. */
typedef struct Tally {
    long operations[OPERATION_KINDS]; /* in the order of operations.c */
    long programs, clashing, clashFree, doubtful, clashes, neighbors, changed, raised, displaced;
    int largest; /* particles of a scene */
} Tally;

/* A set of particles that is asked about in several states. */
typedef struct KeptSet {
    int count;
    int* particles;
    ctSelection* selection; /* or NULL: no set is kept */
    bool isStale;           /* its scene is gone */
} KeptSet;

typedef struct Program {
    const char* name; /* by which it can be run again */
    int step;
    const char* operation;
    Tally* tally;
    randomSource random;
    randomScene scene;      /* its positions are the reference positions */
    double* firstPositions; /* from which the engine's scene was made */
    unsigned char* listed;  /* particles that stand in a leaf in any case, which nothing here must notice; or NULL */
    ctChainTree* tree;
    oracleScene* oracle;

    int movableCount;
    int* movable;     /* links with a torsion or free joint */
    double* state;    /* the bits that ctGetPositions must give */
    double* trial;    /* and those of the open trial */
    double* followed; /* those of the last trial that was followed */
    double* scratch;  /* as many coordinates */
    bool hasTrial;
    bool takesAnyPath; /* each tree is made for an instruction set and a way to test trials that are chosen at random */
    int* roots;        /* per link: the one without parent that it hangs on */
    bool* hasMoved;    /* per root: by an accepted trial since the reference positions */
    bool* isInTrial;   /* per root: by the open trial */
    bool* isDisplaced; /* per particle: by the open trial; NULL: the scene is not flexible */
    bool displaces;    /* the open trial displaces particles */
    PairList limits;   /* what ctGetLimits must give */
    KeptSet kept;
} Program;

/* Takes ownership of the scene. `random` chooses operations and, with takesAnyPath, the paths of the trees. */
void programCreate(Program* program, const char* name, randomScene scene, randomSource random, bool takesAnyPath,
                   Tally* tally);
void programDestroy(Program* program);

/* The engine's scene as it was made at first; its arrays are the program's. */
ctDefinition programDefinition(const Program* program);
ctChainTree* programCreateTree(Program* program);
oracleScene* createOracle(const ctDefinition* definition);

/* ---- Failure: prints the name, the step and what differed, and ends the process with status 1 ---- */

void require(bool condition, const Program* program, const char* format, ...) __attribute__((format(printf, 3, 4)));
void requireStatus(const Program* program, const char* call, ctStatus status, ctStatus expected);
void requireNear(const Program* program, const char* what, int index, double value, double expected, double error);

#define SUCCEED(call) requireStatus(p, #call, call, ctSuccess)
#define FAIL(expected, call) requireStatus(p, #call, call, expected)

/* ---- Common checks and choices ---- */

/* Allowed difference between numbers of the engine and the oracle (nm or other units); larger in chains of thousands of
 * links, each of which adds rounding. */
double numberTolerance(const Program* program);

void* programAllocate(int count, size_t size);
void freeSet(KeptSet* set);
int coordinateCount(const Program* program);
size_t positionBytes(const Program* program);

/* Whether the molecule of a particle has left the reference positions. */
bool hasParticleMoved(const Program* program, int particle);

void requireSameBits(const Program* program, const char* what, const double* values, const double* expected);

/* The engine's state has the bits that it had, and a trial is open or not as before. */
void requireUntouchedState(Program* program);

/* Positions (of ORACLE_STATE or ORACLE_TRIAL) are near the oracle's. */
void requireOraclePositions(Program* program, int which, const double* positions);

/* Counts to be added to, or NULL; and that nothing was subtracted. */
ctCounts* chooseCounts(Program* program, ctCounts* counts);
void requireCounted(const Program* program, const ctCounts* counts);

double chooseCutoff(Program* program);
int chooseParticle(Program* program);
double chooseNoLength(Program* program); /* not finite, or too much */

/* ---- Lists ---- */

/* An oracle's list with the slack that DOUBT needs: values, and how far each is beyond the limit. */
typedef struct Expected {
    int count;
    int* particles; /* of pairs; of single particles twice */
    double *values, *others, *margins;
} Expected;

Expected expectedCreate(int capacity);
void expectedDestroy(Expected* expected);
Expected expectedClashes(const Program* program);

/* Sorts the pairs that a callback has collected; none may have come twice. */
void sortCollected(const Program* program, PairList* list);

/* Sorts a list. All that is certainly beyond the limit is in it, nothing that certainly is not, with the right values
 * (one or two a pair). */
void requireSameList(const Program* program, PairList* list, const Expected* expected, int valueCount);

#endif /* PROGRAM_H_ */
