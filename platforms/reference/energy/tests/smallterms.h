/* smallterms.h: terms of a few particles at given positions, without a scene of the engine. */
#ifndef SMALLTERMS_H_
#define SMALLTERMS_H_

#include "../../chaintree/tests/check.h"
#include "../src/terms.h"
#include "termoracle.h"

enum { SMALL_COUNT = 8 };

/* Particles 0 to 7, each a link that turns about the bond between the two before, on a fixed one. Particle i stands in
 * slot i, but for `unlisted`. */
typedef struct SmallScene {
  double positions[3 * SMALL_COUNT];
  double radii[SMALL_COUNT];
  int links[SMALL_COUNT];
  int parents[SMALL_COUNT];
  uint8_t joints[SMALL_COUNT];
  int torsions[SMALL_COUNT][4];
  int slotOf[SMALL_COUNT];
  ctLeafPositions leaf;
  ctDefinition definition;
} SmallScene;

static inline void makeSmallScene(SmallScene* scene, int unlisted) {
  *scene = (SmallScene){0};
  for (int i = 0; i < SMALL_COUNT; i++) {
    scene->links[i] = i;
    scene->parents[i] = i - 1;
    scene->joints[i] = (uint8_t)(i == 0 ? ctFixedJoint : ctTorsionJoint);
    const int torsion[4] = {i > 1 ? i - 2 : i + 1, i - 1, i, (i + 1) % SMALL_COUNT};
    memcpy(scene->torsions[i], torsion, sizeof torsion);
    scene->slotOf[i] = i == unlisted ? CT_NULL : i;
    scene->positions[3 * i] = 0.1 * i;
    scene->positions[3 * i + 1] = 0.05 * (i * i % 3);
    scene->positions[3 * i + 2] = 0.04 * (i * i * i % 5);
  }
  scene->definition = (ctDefinition){.particleCount = SMALL_COUNT,
                                     .positions = scene->positions,
                                     .radii = scene->radii,
                                     .particleLinks = scene->links,
                                     .linkCount = SMALL_COUNT,
                                     .linkParents = scene->parents,
                                     .linkJoints = scene->joints,
                                     .linkTorsions = (const int(*)[4])scene->torsions};
}

static inline const ctLeafPositions* smallLeaf(SmallScene* scene) {
  for (int i = 0; i < SMALL_COUNT; i++) {
    scene->leaf.x[i] = scene->positions[3 * i];
    scene->leaf.y[i] = scene->positions[3 * i + 1];
    scene->leaf.z[i] = scene->positions[3 * i + 2];
  }
  return &scene->leaf;
}

/* The sum of a set that must be right, at the scene's positions. */
static inline double sumOfSet(SmallScene* scene, const ctTermSet* set) {
  char text[200] = "";
  Terms* terms;
  if (ctTermsCreate(&scene->definition, 1, set, scene->slotOf, &terms, text, sizeof text) != ctSuccess) {
    reportFailure("ctTermsCreate: %s\n", text);
    return 0;
  }
  ctTermsRefresh(terms, NULL, smallLeaf(scene));
  const double sum = ctTermsSum(terms, 0);
  ctTermsDestroy(terms);
  return sum;
}

/* A set that must be refused, with a text that holds `culprit`. */
static inline void checkRefused(const SmallScene* scene, int count, const ctTermSet* sets, const char* culprit) {
  char text[200] = "";
  Terms* terms = (Terms*)text;
  const ctStatus status = ctTermsCreate(&scene->definition, count, sets, scene->slotOf, &terms, text, sizeof text);
  if (status != ctInvalidArgument || terms != NULL || strstr(text, culprit) == NULL) {
    reportFailure("%s: returned %d, \"%s\"\n", culprit, (int)status, text);
  }
}

#endif /* SMALLTERMS_H_ */
