#include "search.h"

#include "resultant.h"
#include "vector.h"

/* The resultant on an arc of turns, by Bernstein coefficients: no more roots than changes of sign (Lane, Riesenfeld
 * 1981). A turn x has tan(x / 2) = +-l / (1 - l), one sign in each half of the circle. */
typedef struct Arc {
  double f[CT_ROOTS + 1];
  double y[CT_REACH + 1];
  double z[CT_REACH + 1];
  double from; /* least and largest l */
  double to;
} Arc;

/* Where nothing is special: the present turns are all 0. */
#define ZERO_COSINE 0.28
#define ZERO_SINE 0.96

/* An arc that is halved so often that it is a point. */
#define DEPTH 48

/* Two closures are one if no cosine and no sine differs by more. */
#define SAME 1e-9

/* How far beyond the ends of an arc its root may lie by rounding. */
#define BEYOND 1e-7

static const double binomials16[CT_ROOTS + 1] = {1,     16,   120,  560,  1820, 4368, 8008, 11440, 12870,
                                                 11440, 8008, 4368, 1820, 560,  120,  16,   1};
static const double binomials4[CT_REACH + 1] = {1, 4, 6, 4, 1};

static void bernsteinOf(int degree, const double* powers, const double* binomials, double sign, double* b) {
  double factor = 1;
  for (int i = 0; i <= degree; i++) {
    b[i] = factor * powers[i] / binomials[i];
    factor *= sign;
  }
}

/* De Casteljau's algorithm: b becomes the right half. */
CT_INLINE void halve(int degree, double* b, double* left) {
  left[0] = b[0];
  for (int i = 1; i <= degree; i++) {
    for (int j = 0; j <= degree - i; j++) {
      b[j] = 0.5 * (b[j] + b[j + 1]);
    }
    left[i] = b[0];
  }
}

static bool isNegative(const double* b) {
  for (int i = 0; i <= CT_REACH; i++) {
    if (b[i] >= 0) {
      return false;
    }
  }
  return true;
}

static int countChanges(const double* f) {
  int changes = 0;
  for (int i = 0; i < CT_ROOTS; i++) {
    changes += (f[i] < 0) != (f[i + 1] < 0) ? 1 : 0;
  }
  return changes;
}

/* Where the polygon of the coefficients crosses zero first. */
static double crossing(const Arc* arc) {
  int i = 0;
  while (i < CT_ROOTS - 1 && (arc->f[i] < 0) == (arc->f[i + 1] < 0)) {
    i++;
  }
  const double part = arc->f[i] / (arc->f[i] - arc->f[i + 1]);
  return arc->from + (arc->to - arc->from) * (i + part) / CT_ROOTS;
}

static bool isSame(const Sway* a, const Sway* b) {
  for (int k = 0; k < 3; k++) {
    if (fabs(a->c[k] - b->c[k]) > SAME || fabs(a->s[k] - b->s[k]) > SAME) {
      return false;
    }
  }
  return true;
}

typedef struct Search {
  const Triangle* triangle;
  Resultant resultant;
  double sign; /* which half of the circle */
  int count;
  Sway* sways;
} Search;

/* Newton's method from l on an arc; true if it leads to a new closure on the arc. */
static bool closeFrom(Search* search, const Arc* arc, double l) {
  const Resultant* r = &search->resultant;
  const double u = 1 - l;
  const double w = search->sign * l;
  const double factor = 1 / (u * u + w * w);
  const double cosine = (u * u - w * w) * factor;
  const double sine = 2 * u * w * factor;
  double y[2], z[2];
  guessOthers(r, cosine, sine, y, z);
  Sway sway;
  const int i = r->piece;
  const int j = (i + 1) % 3;
  const int k = (i + 2) % 3;
  sway.c[i] = cosine * ZERO_COSINE - sine * ZERO_SINE;
  sway.s[i] = cosine * ZERO_SINE + sine * ZERO_COSINE;
  sway.c[j] = y[0];
  sway.s[j] = y[1];
  sway.c[k] = z[0];
  sway.s[k] = z[1];
  if (!closeTriangle(search->triangle, &sway)) {
    return false;
  }
  const double c = sway.c[i] * ZERO_COSINE + sway.s[i] * ZERO_SINE;
  const double s = search->sign * (sway.s[i] * ZERO_COSINE - sway.c[i] * ZERO_SINE);
  const double near = c > 0 ? s / (1 + c + s) : (1 - c) / (s + 1 - c);
  if (!(near >= arc->from - BEYOND && near <= arc->to + BEYOND)) {
    return false;
  }
  for (int n = 0; n < search->count; n++) {
    if (isSame(&search->sways[n], &sway)) {
      return false;
    }
  }
  if (search->count < CT_CLOSURES_MOST) {
    search->sways[search->count++] = sway;
  }
  return true;
}

#ifdef STATS
long arcsSeen, halvings, tries, successes;
#define STAT(x) (x)
#else
#define STAT(x) ((void)0)
#endif

static void searchHalf(Search* search) {
  Arc arcs[DEPTH + 2];
  int depths[DEPTH + 2];
  const Resultant* r = &search->resultant;
  bernsteinOf(CT_ROOTS, r->f, binomials16, search->sign, arcs[0].f);
  bernsteinOf(CT_REACH, r->y, binomials4, search->sign, arcs[0].y);
  bernsteinOf(CT_REACH, r->z, binomials4, search->sign, arcs[0].z);
  arcs[0].from = 0;
  arcs[0].to = 1;
  depths[0] = 0;
  int count = 1;
  while (count > 0) {
    Arc* arc = &arcs[count - 1];
    STAT(arcsSeen++);
    const int changes = countChanges(arc->f);
    if (changes == 0 || isNegative(arc->y) || isNegative(arc->z)) {
      count--;
      continue;
    }
    if (changes == 1) {
      STAT(tries++);
      if (closeFrom(search, arc, crossing(arc))) {
        STAT(successes++);
        count--;
        continue;
      }
    }
    if (depths[count - 1] == DEPTH) {
      count--;
      continue;
    }
    STAT(halvings++);
    const double middle = 0.5 * (arc->from + arc->to);
    Arc* left = arc + 1;
    halve(CT_ROOTS, arc->f, left->f);
    halve(CT_REACH, arc->y, left->y);
    halve(CT_REACH, arc->z, left->z);
    left->from = arc->from;
    left->to = middle;
    arc->from = middle;
    depths[count] = ++depths[count - 1];
    count++;
  }
}

int findSways(const Triangle* triangle, Sway sways[CT_CLOSURES_MOST]) {
  Search search = {.triangle = triangle, .count = 0, .sways = sways};
  makeResultant(triangle, 0, ZERO_COSINE, ZERO_SINE, &search.resultant);
  search.sign = 1;
  searchHalf(&search);
  search.sign = -1;
  searchHalf(&search);
  return search.count;
}
