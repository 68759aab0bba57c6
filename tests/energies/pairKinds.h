/* pairKinds.h: expressions of pairs as operations, and the same as formulas. */
#ifndef PAIR_KINDS_H_
#define PAIR_KINDS_H_

#include "randomPairSet.h"

/* Parameters: sigma (nm), epsilon (kJ/mol), charge, type (a whole number below PAIR_TYPES). */
enum { SIGMA, EPSILON, CHARGE, TYPE };

enum { PAIR_TYPES = 5, PAIR_KINDS = 9 };

typedef struct PairKind {
    pairFormula* formula;
    void (*write)(randomPairSet* set);
    void (*makeTables)(randomPairSet* set, randomSource* random); /* NULL: it has none */
} PairKind;

extern const PairKind pairKinds[PAIR_KINDS];

/* Zeros, or the end of the program. */
void* allocateZeros(size_t count, size_t size);

#endif /* PAIR_KINDS_H_ */
