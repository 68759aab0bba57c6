/* The polynomial of Ewald summation against the error function. */
#include <math.h>

#include "../../chaintree/tests/check.h"
#include "../src/ewald.h"
#include "ctenergy.h"

/* The largest error, relative to alpha. */
static double largestError(double alpha, double cutoff) {
  EwaldPolynomial polynomial;
  double largest = 0;
  ctEwaldCreate(alpha, cutoff, &polynomial);
  for (int i = 1; i <= 10000; i++) {
    const double r = cutoff * i / 10000;
    largest = fmax(largest, fabs(ctEwaldSmooth(&polynomial, r * r) - erf(alpha * r) / r) / alpha);
  }
  return largest;
}

int main(void) {
  static const double reaches[] = {0.01, 0.5, 2, 3, 3.5, 4.5, CT_MOST_EWALD};
  for (int i = 0; i < 7; i++) {
    CHECK(largestError(reaches[i], 1) < 2e-8);
    CHECK(largestError(reaches[i] / 1.3, 1.3) < 2e-8);
  }
  return checkResult();
}
