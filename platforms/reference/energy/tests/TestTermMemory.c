/* Every allocation of terms fails once: the call says so, leaves nothing behind, and works the next time.
 *
 * The program puts its own functions before the C library's allocator; where that cannot be done, it is skipped. */
#include "../../chaintree/tests/failingallocator.h"
#include "smallterms.h"

#ifndef HAS_GLIBC_ALLOCATOR

int main(void) {
  return 77;
}

#else

/* Terms of all kinds of memory: maps, expressions, centroids, terms of few joints and of many. */
int main(void) {
  static SmallScene scene;
  static double coefficients[16 * 4];
  static const int particles[] = {0, 1, 2, 3, 4, 5, 6, 7};
  static const double numbers[] = {0, 1, 2};
  static const double weights[] = {0.25, 0.75, 0.5, 0.5};
  static const ctInput input = {ctMeasureX, {1, 0, 0, 0}};
  static const ctOperation operation = {ctInputOperator, {0, 0, 0}, 0};
  static const ctExpression expression = {1, &input, 1, &operation};
  const ctTorsionMap maps[] = {{1, coefficients}, {2, coefficients}};
  const ctTermSet sets[] = {{ctTorsionMapTerm, 1, 8, particles, 1, numbers, 2, maps, NULL, 0, false},
                            {ctPeriodicTorsionTerm, 2, 4, particles, 3, numbers, 0, NULL, NULL, 0, false},
                            {ctExpressionTerm, 4, 2, particles, 0, NULL, 0, NULL, &expression, 0, false},
                            {ctCentroidTerm, 1, 4, particles, 4, weights, 0, NULL, &expression, 2, false}};
  static const double periodic[] = {1, 2, 3, 4, 5, 6};
  ctTermSet given[4];
  memcpy(given, sets, sizeof sets);
  given[1].parameters = periodic;
  printf("\n"); /* its buffer is no leak of ours */
  makeSmallScene(&scene, CT_NULL);
  scene.definition.isFlexible = true;
  const int before = live;
  int n = 0;
  do {
    Terms* terms = NULL;
    char text[200] = "";
    failAllocation(n++);
    const ctStatus status = ctTermsCreate(&scene.definition, 4, given, scene.slotOf, &terms, text, sizeof text);
    allocationsLeft = -1;
    CHECK((status == ctOutOfMemory) == hasFailed && (terms == NULL) == hasFailed);
    CHECK(strcmp(text, hasFailed ? "out of memory" : "") == 0);
    CHECK(hasFailed == (live == before));
    if (terms != NULL) { /* from here on, nothing needs memory */
      failAllocation(0);
      ctTermsRefresh(terms, NULL, smallLeaf(&scene));
      CHECK(isfinite(ctTermsSum(terms, 0)));
      CHECK(!hasFailed);
      allocationsLeft = -1;
      ctTermsDestroy(terms);
    }
    CHECK(live == before);
    hasFailed = terms == NULL;
  } while (hasFailed);
  CHECK(n > 15);
  return checkResult();
}

#endif
