/* A pair expression as kernels run it: on many pairs of particles at a time. */
#ifndef CT_TAPE_H_
#define CT_TAPE_H_

#include "leafpair.h"
#include "tapegraph.h"

/* A pair of leaves has at most so many pairs of particles. */
enum { MOST_LEAF_PAIRS = CT_LEAF_WIDTH * CT_LEAF_WIDTH };

/* A table, and its values as floats. */
typedef struct TapeTable {
  ctTable exact;
  float* values;
  bool isLong; /* floats do not count its values */
} TapeTable;

/* Where numbers are in the scratch: one for each pair, or sixteen that are the same. */
typedef struct TapeValue {
  int begin;
  int step; /* from sixteen pairs to the next: 16 or 0 */
} TapeValue;

/* An operation of a graph. */
typedef struct TapeStep {
  ctOperator kind;
  bool isOfColumns; /* its arguments are the columns of both sides */
  TapeValue arguments[3];
  int columns[2]; /* or that of the one column that it reads */
  int side;       /* of the first of these */
  const TapeTable* table;
  int result; /* where it begins in the scratch */
} TapeStep;

typedef struct Tape {
  int stepCount;
  TapeStep* steps;
  int squaredBegin; /* where the squares of distances go in the scratch */
  TapeValue result;
  float* scratch;
  int columnCount; /* that steps read */
  TapeColumn* columnKinds;
  float* columns; /* of each leaf columnCount times sixteen; 0 where a slot holds no particle */
  bool isExact;   /* some number is no float: pairs have to be evaluated in double */

  /* The expression as it was given, for evaluation in double. */
  int operationCount;
  ctOperation* operations;
  int parametersPerParticle;
  int tableCount;
  ctTable* tables;       /* with values of its own */
  TapeTable* tapeTables; /* of these */
  double* results;       /* scratch, one an operation */
} Tape;

/* Which pairs of particles of two leaves count, and how. */
typedef struct TapePair {
  const LeafFrame* frames[2];
  const float* columns[2];
  unsigned occupied[2];              /* bits: slots that hold a particle */
  const uint16_t* allowed;           /* per slot of the first leaf, bits: slots of the second that count; NULL: all */
  const int (*times)[CT_LEAF_WIDTH]; /* how often each pair counts; NULL: once */
} TapePair;

/* How pairs count by their distance; see ctPairSet. */
typedef struct TapeRange {
  bool hasCutoff;
  bool hasSwitch;
  float squaredCutoff; /* without a cutoff, that of slots without a particle */
  float switchingDistance;
  float inverseSwitchWidth;
} TapeRange;

/* Makes the tape of a valid pair set. False, and nothing to free, if there is no memory. */
bool ctTapeCreate(Tape* tape, const ctPairSet* set, int particleCount, int leafCount, const int* slotOf);
void ctTapeFree(Tape* tape);

/* The expression of a distance and the parameters of two particles in double, by the C library's functions. */
double ctTapeEvaluate(const Tape* tape, double distance, const double* first, const double* second);

#endif /* CT_TAPE_H_ */
