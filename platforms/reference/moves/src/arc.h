/* arc.h: the resultant on an arc of turns, by Bernstein coefficients. It has no more roots there than these have
 * changes of sign, and one if they have one (Lane, Riesenfeld 1981). */
#ifndef CT_ARC_H_
#define CT_ARC_H_

#include "resultant.h"

/* A turn x has tan(x / 2) = l / (1 - l) in one half of the circle, and - l / (1 - l) in the other. */
typedef struct Arc {
  double f[CT_ROOTS + 1];
  double y[CT_REACH + 1];
  double z[CT_REACH + 1];
  double from; /* least and largest l */
  double to;
  int depth; /* how often it has been halved */
} Arc;

/* Half of the circle: that of positive turns for sign 1, that of negative ones for -1. */
void makeHalfCircle(const Resultant* resultant, double sign, Arc* arc);

/* Leaves the right half in `arc`. */
void halveArc(Arc* arc, Arc* left);

/* True if y or z is real nowhere on it. */
bool isUnreal(const Arc* arc);

int countChanges(const Arc* arc);

/* The least and the largest absolute value of a coefficient. */
void rangeOfArc(const Arc* arc, double* least, double* most);

/* About where the root is if there is one. */
double placeOfRoot(const Arc* arc);

#endif /* CT_ARC_H_ */
