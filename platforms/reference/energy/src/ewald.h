/* Coulomb energies of Ewald summation in direct space: erfc(alpha r) / r is 1 / r less a polynomial of r^2. */
#ifndef CT_EWALD_H_
#define CT_EWALD_H_

enum { EWALD_TERMS = 30 };

/* erf(alpha r) / r up to the cutoff: the sum of coefficients[n] t^n, t = scale r^2 - 1, which is in [-1, 1].
 * Coefficients alternate in sign, and their magnitudes sum to about the value at r = 0, so rounding loses little. */
typedef struct EwaldPolynomial {
  int count; /* of coefficients, an even number; 0: no Ewald summation */
  float scale;
  float coefficients[EWALD_TERMS];
  double exactScale; /* the same in double precision */
  double exact[EWALD_TERMS];
} EwaldPolynomial;

/* For an alpha above 0 and a cutoff of CT_MOST_EWALD / alpha at most. */
void ctEwaldCreate(double alpha, double cutoff, EwaldPolynomial* polynomial);

/* erf(alpha r) / r. */
double ctEwaldSmooth(const EwaldPolynomial* polynomial, double squaredDistance);

#endif /* CT_EWALD_H_ */
