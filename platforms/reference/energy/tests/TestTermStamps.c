/* Trials of several links, and those of displaced particles, are told apart by a number of 32 bits. When it overflows,
 * no term may be taken for one that was computed already. Looks inside the terms. */
#include "../src/terms.c"

#include "smallterms.h"

/* A trial that changes both terms, each of which it finds twice. */
static void testStamps(Terms* terms, const TrialView* view) {
  const double first = ctTermsChange(terms, view); /* leaves a 1 */
  CHECK(first != 0 && terms->changedCount == 2);
  const uint32_t starts[] = {UINT32_MAX, 7, UINT32_MAX - 1, UINT32_MAX};
  for (int i = 0; i < 4; i++) {
    terms->trial = starts[i];
    CHECK(ctTermsChange(terms, view) == first);
    CHECK(terms->changedCount == 2);
  }
}

int main(void) {
  static SmallScene scene;
  static const int particles[] = {0, 1, 2, 3, 1, 2, 3, 4};
  static const double parameters[] = {1, 0, 5, 1, 0, 5};
  static const ctTermSet set = {ctPeriodicTorsionTerm, 2, 4, particles, 3, parameters, 0, NULL, NULL, 0, false};
  static const ctPiece pieces[] = {{0, 0}, {3, 1}, {4, 2}};
  static const ctTransform motions[] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},
                                        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0.1, 0}},
                                        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0.1}}};
  static const int links[] = {2, 3};
  static const ctPiece displaced[] = {{0, 0}, {2, 1}, {3, 2}}; /* particles 2 and all behind it */
  char text[200] = "";
  Terms* terms;
  makeSmallScene(&scene, CT_NULL);
  CHECK_SUCCESS(ctTermsCreate(&scene.definition, 1, &set, scene.slotOf, &terms, text, sizeof text));
  ctTermsRefresh(terms, NULL, smallLeaf(&scene));
  testStamps(terms, &(TrialView){NULL, &scene.leaf, 3, pieces, motions, 2, links});
  ctTermsDestroy(terms);
  scene.definition.isFlexible = true;
  CHECK_SUCCESS(ctTermsCreate(&scene.definition, 1, &set, scene.slotOf, &terms, text, sizeof text));
  ctTermsRefresh(terms, NULL, smallLeaf(&scene));
  testStamps(terms, &(TrialView){NULL, &scene.leaf, 3, displaced, motions, 0, NULL});
  ctTermsDestroy(terms);
  return checkResult();
}
