/* randomterms.h: term sets of every kind on particles of a random scene. */
#ifndef RANDOMTERMS_H_
#define RANDOMTERMS_H_

#include "branches.h"
#include "ctenergy.h"

enum { MOST_SETS = 64, MOST_TERMS = 32, MOST_WIDTH = 8, MOST_INPUTS = 4, MOST_OPERATIONS = 32 };

/* The arrays of a set. */
typedef struct SetArrays {
  int particles[MOST_TERMS * MOST_WIDTH];
  double parameters[MOST_TERMS * (MOST_WIDTH + MOST_INPUTS)];
  ctExpression expression;
  ctInput inputs[MOST_INPUTS];
  ctOperation operations[MOST_OPERATIONS];
} SetArrays;

typedef struct RandomTerms {
  int setCount;
  ctTermSet sets[MOST_SETS];
  SetArrays arrays[MOST_SETS];
  ctTorsionMap maps[2];
  double coefficients[2][16 * 24 * 24];
} RandomTerms;

static inline int drawListed(Branches* b) {
  int atom;
  do {
    atom = drawBelow(b, b->atomCount);
  } while (!hasSlot(b, atom));
  return atom;
}

static inline bool areBonded(const Branches* b, int i, int j) {
  return b->bondedTo[i] == j || b->bondedTo[j] == i;
}

/* Different particles: mostly bonded to each other, sometimes any. */
static inline void drawParticles(Branches* b, int count, int* particles) {
  const int wanted = drawBelow(b, 4) > 0 ? 2000 : 0;
  for (int i = 0; i < count; i++) {
    for (int attempt = 0;; attempt++) {
      const int atom = drawListed(b);
      bool isNew = true;
      bool isNear = i == 0;
      for (int k = 0; k < i; k++) {
        isNew &= particles[k] != atom;
        isNear |= areBonded(b, particles[k], atom) && (k == i - 1 || attempt > wanted / 2);
      }
      if (isNew && (isNear || attempt >= wanted)) {
        particles[i] = atom;
        break;
      }
    }
  }
}

static inline void addOperation(SetArrays* arrays, ctOperator kind, int a, int b, double constant) {
  arrays->operations[arrays->expression.operationCount++] = (ctOperation){kind, {a, b, -7}, constant};
}

/* A sum over measures, of which each is squared, a cosine or a Gaussian, times a parameter. */
static inline void drawExpression(Branches* b, int width, ctTermSet* set, SetArrays* arrays) {
  static const int widths[] = {1, 1, 1, 2, 3, 4};
  ctExpression* e = &arrays->expression;
  *e = (ctExpression){.inputs = arrays->inputs, .operations = arrays->operations};
  const int inputs = 1 + drawBelow(b, MOST_INPUTS);
  int sum = 0;
  for (int i = 0; i < inputs; i++) {
    ctInput* input = &arrays->inputs[i];
    do {
      input->measure = (ctMeasure)drawBelow(b, 6);
    } while (widths[input->measure] > width);
    const int first = drawBelow(b, width);
    for (int k = 0; k < 4; k++) {
      input->particles[k] = k < widths[input->measure] ? (first + k) % width : -1;
    }
    e->inputCount++;
    addOperation(arrays, ctInputOperator, i, -1, 0);
    const int form = drawBelow(b, 3);
    addOperation(arrays, form == 1 ? ctCosOperator : ctSquareOperator, e->operationCount - 1, -1, 0);
    if (form == 2) {
      addOperation(arrays, ctNegateOperator, e->operationCount - 1, -1, 0);
      addOperation(arrays, ctExpOperator, e->operationCount - 1, -1, 0);
    }
    addOperation(arrays, ctParameterOperator, i, -1, 0);
    addOperation(arrays, ctMultiplyOperator, e->operationCount - 2, e->operationCount - 1, 0);
    if (i > 0) {
      addOperation(arrays, ctAddOperator, sum, e->operationCount - 1, 0);
    }
    sum = e->operationCount - 1;
  }
  set->expression = e;
  set->parametersPerTerm = inputs;
}

static inline void drawParameters(Branches* b, ctTermKind kind, int count, double* p) {
  for (int i = 0; i < count; i++) {
    p[i] = 10 * drawReal(b) - 5;
  }
  switch (kind) {
    case ctHarmonicBondTerm:
      p[0] = 0.3 * drawReal(b);
      p[1] = 1000 * drawReal(b);
      break;
    case ctHarmonicAngleTerm:
      p[0] = PI * drawReal(b);
      p[1] = 100 * drawReal(b);
      break;
    case ctPeriodicTorsionTerm:
      p[0] = drawBelow(b, 8);
      break;
    case ctTorsionMapTerm:
      p[0] = drawBelow(b, 2);
      break;
    case ctExceptionTerm:
      p[0] *= 0.05;
      p[1] = 0.05 * drawReal(b);
      p[2] = drawReal(b);
      break;
    case ctCentroidTerm:
      for (int i = 0; i < count; i++) {
        p[i] = 0.1 + drawReal(b);
      }
      break;
    default:
      break;
  }
}

/* `any`: for an expression, its particles or groups. */
static inline void addRandomSet(Branches* b, RandomTerms* terms, ctTermKind kind, int count, int any) {
  static const int widths[] = {2, 3, 4, 4, 8, 2, 0, 0};
  static const int parameters[] = {2, 2, 3, 6, 1, 3, 0, 0};
  SetArrays* arrays = &terms->arrays[terms->setCount];
  ctTermSet* set = &terms->sets[terms->setCount++];
  *set = (ctTermSet){.kind = kind,
                     .count = count,
                     .particlesPerTerm = kind == ctExpressionTerm ? any : widths[kind],
                     .particles = arrays->particles,
                     .parametersPerTerm = parameters[kind],
                     .parameters = arrays->parameters};
  if (kind == ctExpressionTerm || kind == ctCentroidTerm) {
    drawExpression(b, any, set, arrays);
  }
  if (kind == ctCentroidTerm) {
    set->groupsPerTerm = any;
    set->particlesPerTerm = any * (1 + (2 * any <= MOST_WIDTH ? drawBelow(b, 2) : 0));
    set->parametersPerTerm += set->particlesPerTerm;
  }
  if (kind == ctTorsionMapTerm) {
    set->mapCount = 2;
    set->maps = terms->maps;
  }
  for (int i = 0; i < count; i++) {
    int* p = arrays->particles + i * set->particlesPerTerm;
    drawParticles(b, set->particlesPerTerm, p);
    if (i > 0 && drawBelow(b, 3) == 0) { /* several terms of the same particles are usual for torsions */
      memcpy(p, p - set->particlesPerTerm, (size_t)set->particlesPerTerm * sizeof *p);
    }
    drawParameters(b, kind, set->parametersPerTerm, arrays->parameters + i * set->parametersPerTerm);
  }
}

/* A set of `count` terms of each kind, expressions of several widths, and `single` sets of one term. */
static inline void drawTerms(Branches* b, RandomTerms* terms, int count, int single) {
  static const int sizes[] = {24, 5};
  terms->setCount = 0;
  for (int m = 0; m < 2; m++) {
    terms->maps[m] = (ctTorsionMap){sizes[m], terms->coefficients[m]};
    for (int i = 0; i < 16 * sizes[m] * sizes[m]; i++) {
      terms->coefficients[m][i] = 2 * drawReal(b) - 1;
    }
  }
  for (int kind = ctHarmonicBondTerm; kind < ctExpressionTerm && count > 0; kind++) {
    addRandomSet(b, terms, (ctTermKind)kind, count, 0);
  }
  for (int width = 1; width <= 6 && count > 0; width++) {
    addRandomSet(b, terms, ctExpressionTerm, count, width);
    addRandomSet(b, terms, ctCentroidTerm, count, width);
  }
  for (int i = 0; i < single; i++) {
    addRandomSet(b, terms, (ctTermKind)drawBelow(b, ctCentroidTerm + 1), 1, 1 + drawBelow(b, 6));
  }
}

#endif /* RANDOMTERMS_H_ */
