#include "arc.h"

#include <math.h>

static void bernsteinOf(int degree, const double* powers, const double* binomials, double sign, double* b) {
  double factor = 1;
  for (int i = 0; i <= degree; i++) {
    b[i] = factor * powers[i] / binomials[i];
    factor *= sign;
  }
}

void makeHalfCircle(const Resultant* r, double sign, Arc* arc) {
  static const double binomials16[CT_ROOTS + 1] = {1,     16,   120,  560,  1820, 4368, 8008, 11440, 12870,
                                                   11440, 8008, 4368, 1820, 560,  120,  16,   1};
  static const double binomials4[CT_REACH + 1] = {1, 4, 6, 4, 1};
  bernsteinOf(CT_ROOTS, r->f, binomials16, sign, arc->f);
  bernsteinOf(CT_REACH, r->y, binomials4, sign, arc->y);
  bernsteinOf(CT_REACH, r->z, binomials4, sign, arc->z);
  arc->from = 0;
  arc->to = 1;
  arc->depth = 0;
}

/* De Casteljau's algorithm, unrolled so that what it computes stays in registers: b becomes the right half. Means of
 * neighbours are left as sums until the end. */
CT_INLINE void halve(int degree, double* b, double* left) {
  double edge[CT_ROOTS + 1];
  double share = 1;
#pragma GCC unroll 17
  for (int i = 0; i <= degree; i++) {
    double sum = b[i];
#pragma GCC unroll 17
    for (int k = 0; k < i; k++) {
      const double former = edge[k];
      edge[k] = sum;
      sum += former;
    }
    edge[i] = sum;
    left[i] = share * sum;
    share *= 0.5;
  }
  share = 1;
#pragma GCC unroll 17
  for (int i = 0; i <= degree; i++) {
    b[degree - i] = share * edge[i];
    share *= 0.5;
  }
}

void halveArc(Arc* arc, Arc* left) {
  halve(CT_ROOTS, arc->f, left->f);
  halve(CT_REACH, arc->y, left->y);
  halve(CT_REACH, arc->z, left->z);
  const double middle = 0.5 * (arc->from + arc->to);
  left->from = arc->from;
  left->to = middle;
  left->depth = ++arc->depth;
  arc->from = middle;
}

static bool isNegative(const double* b) {
  for (int i = 0; i <= CT_REACH; i++) {
    if (b[i] >= 0) {
      return false;
    }
  }
  return true;
}

bool isUnreal(const Arc* arc) {
  return isNegative(arc->y) || isNegative(arc->z);
}

int countChanges(const Arc* arc) {
  int changes = 0;
  for (int i = 0; i < CT_ROOTS; i++) {
    changes += (arc->f[i] < 0) != (arc->f[i + 1] < 0) ? 1 : 0;
  }
  return changes;
}

void rangeOfArc(const Arc* arc, double* least, double* most) {
  double low = fabs(arc->f[0]);
  double high = low;
  for (int i = 1; i <= CT_ROOTS; i++) {
    const double size = fabs(arc->f[i]);
    low = size < low ? size : low;
    high = size > high ? size : high;
  }
  *least = low;
  *most = high;
}

/* Where the polygon of the coefficients crosses zero first. */
double placeOfRoot(const Arc* arc) {
  int i = 0;
  while (i < CT_ROOTS - 1 && (arc->f[i] < 0) == (arc->f[i + 1] < 0)) {
    i++;
  }
  const double part = arc->f[i] / (arc->f[i] - arc->f[i + 1]);
  return arc->from + (arc->to - arc->from) * (i + part) / CT_ROOTS;
}
