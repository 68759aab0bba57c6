/* termscene.h: a random scene with random terms, which follow its trials, and the values that the oracle has for them.
 */
#ifndef TERMSCENE_H_
#define TERMSCENE_H_

#include "../src/terms.h"
#include "randomterms.h"
#include "termoracle.h"

typedef struct TermScene {
  Branches branches;
  RandomTerms random;
  ctChainTree* tree;
  Terms* terms;
  long double values[MOST_SETS][MOST_TERMS];    /* of the state */
  long double newValues[MOST_SETS][MOST_TERMS]; /* of the trial */
} TermScene;

/* The slot of each particle, or CT_NULL. */
static inline void findSlots(const ctChainTree* tree, int atomCount, int* slotOf) {
  static int particles[CT_LEAF_WIDTH * 4 * MOST_ATOMS];
  const int count = CT_LEAF_WIDTH * ctGetLeafCount(tree);
  if (count > (int)(sizeof particles / sizeof *particles)) {
    abort();
  }
  ctGetLeafParticles(tree, particles);
  for (int i = 0; i < atomCount; i++) {
    slotOf[i] = CT_NULL;
  }
  for (int slot = 0; slot < count; slot++) {
    if (particles[slot] != CT_NULL) {
      slotOf[particles[slot]] = slot;
    }
  }
}

static inline void evaluateOracle(const RandomTerms* random, const double* positions,
                                  long double values[MOST_SETS][MOST_TERMS]) {
  for (int s = 0; s < random->setCount; s++) {
    for (int i = 0; i < random->sets[s].count; i++) {
      values[s][i] = oracleTerm(&random->sets[s], i, positions);
    }
  }
}

static inline void refreshTerms(TermScene* scene) {
  static double positions[3 * MOST_ATOMS];
  ctGetPositions(scene->tree, positions);
  evaluateOracle(&scene->random, positions, scene->values);
  ctTermsRefresh(scene->terms, scene->tree, ctGetLeaves(scene->tree));
}

/* Makes scene and terms of branches and sets that have been drawn. */
static inline void createTermScene(TermScene* scene) {
  static int slotOf[MOST_ATOMS];
  char text[200] = "";
  const ctDefinition definition = describeBranches(&scene->branches);
  scene->tree = checkedCreate(&definition);
  findSlots(scene->tree, definition.particleCount, slotOf);
  if (ctTermsCreate(&definition, scene->random.setCount, scene->random.sets, slotOf, &scene->terms, text,
                    sizeof text) != ctSuccess) {
    printf("ctTermsCreate: %s\n", text);
    exit(1);
  }
  refreshTerms(scene);
}

static inline void destroyTermScene(TermScene* scene) {
  ctTermsDestroy(scene->terms);
  ctDestroy(scene->tree);
}

/* The change of all terms in the open trial. */
static inline double changeOfTerms(TermScene* scene) {
  TrialView view = {.tree = scene->tree, .state = ctGetLeaves(scene->tree)};
  view.pieceCount = ctGetTrialPieces(scene->tree, &view.pieces, &view.motions);
  view.linkCount = ctGetTrialLinks(scene->tree, &view.links);
  return ctTermsChange(scene->terms, &view);
}

/* Evaluates the oracle for the open trial: the change, and how large the numbers are of which it is made. */
static inline long double changeOfOracle(TermScene* scene, long double* size) {
  static double positions[3 * MOST_ATOMS];
  long double change = 0;
  *size = 1;
  CHECK_SUCCESS(ctGetTrialPositions(scene->tree, positions));
  evaluateOracle(&scene->random, positions, scene->newValues);
  for (int s = 0; s < scene->random.setCount; s++) {
    for (int i = 0; i < scene->random.sets[s].count; i++) {
      change += scene->newValues[s][i] - scene->values[s][i];
      *size += fabsl(scene->newValues[s][i]) + fabsl(scene->values[s][i]);
    }
  }
  return change;
}

/* Makes the open trial the state. */
static inline void acceptTrial(TermScene* scene) {
  CHECK_SUCCESS(ctAccept(scene->tree, NULL));
  ctTermsAccept(scene->terms);
  memcpy(scene->values, scene->newValues, sizeof scene->values);
}

static inline void checkSums(const TermScene* scene) {
  for (int s = 0; s < scene->random.setCount; s++) {
    long double sum = 0;
    long double size = 1;
    for (int i = 0; i < scene->random.sets[s].count; i++) {
      sum += scene->values[s][i];
      size += fabsl(scene->values[s][i]);
    }
    const double found = ctTermsSum(scene->terms, s);
    if (!(fabsl(found - sum) <= 1e-9L * size)) {
      reportFailure("set %d, of kind %d, sums up to %.17g, not %.17Lg\n", s, (int)scene->random.sets[s].kind, found,
                    sum);
    }
  }
}

#endif /* TERMSCENE_H_ */
