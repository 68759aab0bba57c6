/* A pair expression as wide functions run it: on many pairs of particles at a time. */
#ifndef CT_TAPE_H_
#define CT_TAPE_H_

#include "leafpair.h"
#include "pairexpression.h"
#include "tapegraph.h"

/* The most pairs of particles of two leaves. */
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

/* A second operation of a step that adds, subtracts or multiplies, with its third argument: no result is stored between
 * the two. */
typedef enum TapeSequel { NO_SEQUEL, THEN_ADD, THEN_SUBTRACT, THEN_SUBTRACT_FROM, THEN_MULTIPLY } TapeSequel;

/* An operation of a graph, or two. */
typedef struct TapeStep {
  ctOperator kind;
  TapeSequel sequel;
  bool isOfColumns; /* its first two arguments are the columns of both sides */
  TapeValue arguments[3];
  int columns[2]; /* or that of the one column that it reads */
  int side;       /* of the first of these */
  const TapeTable* table;
  int result; /* where it begins in the scratch */
} TapeStep;

/* The most groups of sixteen pairs that a tape runs on at a time: enough that a change of steps costs little, and few
 * enough that results stay in the cache. All pairs of two leaves fit. */
enum { MOST_SIXTEENS = 64, MOST_BATCH = MOST_SIXTEENS * CT_LEAF_WIDTH };

/* The pairs of particles of two leaves, in a batch. */
typedef struct TapePart {
  int number; /* the caller's */
  int begin;  /* its first sixteen */
  int pairCount;
  bool hasTimes;
} TapePart;

/* The pairs of particles that count, of several pairs of leaves. Only the end of a part may have a gap. */
typedef struct TapeBatch {
  int count; /* sixteens */
  int partCount;
  TapePart parts[MOST_SIXTEENS];
  const float* columns[2][MOST_SIXTEENS + CT_LEAF_WIDTH]; /* of both leaves, for each sixteen */
  /* Sixteen times the slot of the first leaf, plus that of the second. */
  _Alignas(CACHE_LINE) int places[MOST_BATCH + CT_LEAF_WIDTH];
  _Alignas(CACHE_LINE) float times[MOST_BATCH]; /* how often a pair counts, where a part has times */
} TapeBatch;

typedef struct Tape {
  int stepCount;
  TapeStep* steps;
  int squaredBegin; /* where the squares of distances go in the scratch */
  TapeValue result;
  float* scratch;
  TapeBatch* batch;
  int columnCount; /* that steps read */
  TapeColumn* columnKinds;
  float* columns;         /* of each leaf columnCount times sixteen; 0 where a slot holds no particle */
  bool constantsAreExact; /* one of them, or of the tables' values, is no float */
  bool isExact;           /* some number is no float: pairs have to be evaluated in double */
  PairExpression expression;
  TapeTable* tables; /* of the expression */
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

/* Makes the tape of a valid pair set, of which all parameters of a particle but the first `fixedCount` may change
 * later. False, and nothing to free, if there is no memory. */
bool ctTapeCreate(Tape* tape, const ctPairSet* set, int fixedCount, int particleCount, int leafCount,
                  const int* slotOf);
void ctTapeFree(Tape* tape);

/* Sets the parameters of all particles, which are those of one particle every `stride` numbers. */
void ctTapeSetParameters(Tape* tape, int particleCount, const int* slotOf, const double* parameters, int stride);

#endif /* CT_TAPE_H_ */
