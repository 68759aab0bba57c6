/* resultant.h: the equations of a triangle as one polynomial in one turn. */
#ifndef CT_RESULTANT_H_
#define CT_RESULTANT_H_

#include "../../simd/inline.h"
#include "triangle.h"

#define CT_ROOTS 16 /* degree of the resultant */
#define CT_REACH 4  /* degree of the discriminants */

/* What the turn x of one piece leaves of the others, y of the next piece and z of that after it. With X = (1, cos x,
 * sin x) and likewise Y and Z, the equations are X'AY = 0, Y'BZ = 0 and Z'CX = 0. */
typedef struct Resultant {
  int piece;
  double a[3][3];
  double b[3][3];
  double c[3][3];
  /* Polynomials in t = tan(x / 2), by powers. */
  double f[CT_ROOTS + 1]; /* zero where y and z exist, real or not; positive where just one of them is real */
  double scale;           /* of the terms whose difference f is: coefficients of its Bernstein form are no larger */
  double y[CT_REACH + 1]; /* negative where no y is real */
  double z[CT_REACH + 1]; /* negative where no z is real */
} Resultant;

/* The resultant of a triangle after one of its pieces has turned by atan2(sine, cosine). */
void makeResultant(const Triangle* triangle, int piece, double cosine, double sine, Resultant* resultant);

/* A y and a z that fulfil the two equations which x is in. */
typedef struct Others {
  double y[2]; /* cosine and sine */
  double z[2];
  double gap; /* residual of the third equation */
} Others;

/* The four of x, given by cosine and sine. Where y or z is not real, the nearest. */
void findOthers(const Resultant* resultant, double cosine, double sine, Others others[4]);

#endif /* CT_RESULTANT_H_ */
