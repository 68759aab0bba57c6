#include "ewald.h"

#include <math.h>

#define PI 3.14159265358979323846

/* The accuracy of the polynomial, as a part of alpha: less than rounding in single precision loses. */
static const double accuracy = 1e-8;

/* The coefficients of Chebyshev polynomials whose sum is erf(alpha r) / r at EWALD_TERMS points. */
static void expand(double alpha, double cutoff, double chebyshev[EWALD_TERMS]) {
  for (int n = 0; n < EWALD_TERMS; n++) {
    chebyshev[n] = 0;
  }
  for (int i = 0; i < EWALD_TERMS; i++) {
    const double angle = PI * (i + 0.5) / EWALD_TERMS;
    const double distance = cutoff * sqrt((1 + cos(angle)) / 2);
    const double value = erf(alpha * distance) / distance;
    for (int n = 0; n < EWALD_TERMS; n++) {
      chebyshev[n] += (n == 0 ? 1.0 : 2.0) / EWALD_TERMS * value * cos(n * angle);
    }
  }
}

/* The least even number of terms that are accurate. */
static int countTerms(double alpha, const double chebyshev[EWALD_TERMS]) {
  double rest = 0;
  int count = EWALD_TERMS;
  while (count > 2) {
    rest += fabs(chebyshev[count - 1]) + fabs(chebyshev[count - 2]);
    if (rest > accuracy * alpha) {
      break;
    }
    count -= 2;
  }
  return count;
}

void ctEwaldCreate(double alpha, double cutoff, EwaldPolynomial* polynomial) {
  double chebyshev[EWALD_TERMS];
  double powers[2][EWALD_TERMS + 1] = {{1}, {0, 1}}; /* of two consecutive Chebyshev polynomials, in turns */
  expand(alpha, cutoff, chebyshev);
  *polynomial = (EwaldPolynomial){.count = countTerms(alpha, chebyshev), .exactScale = 2 / (cutoff * cutoff)};
  polynomial->scale = (float)polynomial->exactScale;
  for (int n = 0; n < polynomial->count; n++) {
    double* present = powers[n % 2];
    const double* next = powers[(n + 1) % 2];
    for (int k = 0; k <= n; k++) {
      polynomial->exact[k] += chebyshev[n] * present[k];
    }
    for (int k = n + 2; k >= 0; k--) { /* T(n+2) = 2 t T(n+1) - T(n) */
      if (k < EWALD_TERMS) {
        present[k] = (k > 0 ? 2 * next[k - 1] : 0) - present[k];
      }
    }
  }
  for (int k = 0; k < polynomial->count; k++) {
    polynomial->coefficients[k] = (float)polynomial->exact[k];
  }
}

double ctEwaldSmooth(const EwaldPolynomial* polynomial, double squaredDistance) {
  const double t = polynomial->exactScale * squaredDistance - 1;
  double sum = 0;
  for (int k = polynomial->count - 1; k >= 0; k--) {
    sum = sum * t + polynomial->exact[k];
  }
  return sum;
}
