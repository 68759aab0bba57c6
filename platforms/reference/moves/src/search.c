#include "search.h"

#include "arc.h"
#include "vector.h"

/* Turns count from here, where nothing is special: the present turns are all 0. */
#define ZERO_COSINE 0.28
#define ZERO_SINE 0.96

/* An arc that has been halved so often is a point. */
#define DEPTH 48

/* Two closures are one if no cosine and no sine differs by more. */
#define SAME 1e-9

/* How far beyond the ends of an arc its root may lie by rounding. */
#define BEYOND 1e-7

/* Rounding of coefficients, as a part of the terms that they are the difference of: below the first it may have changed
 * signs, and below the second it is all that there is. */
#define NOISE 4e-15
#define NOTHING 4e-17

typedef struct Search {
  const Triangle* triangle;
  Resultant resultant;
  double sign;     /* which half of the circle */
  bool isDoubtful; /* rounding may have hidden a root */
  int count;
  Sway* sways;
  bool isTaken[CT_CLOSURES_MOST]; /* by an arc, as its root */
} Search;

static bool isSame(const Sway* a, const Sway* b) {
  for (int k = 0; k < 3; k++) {
    if (fabs(a->c[k] - b->c[k]) > SAME || fabs(a->s[k] - b->s[k]) > SAME) {
      return false;
    }
  }
  return true;
}

/* The closure to which Newton's method leads from a turn and the others, new or not; -1 if to none. */
static int closeFrom(Search* search, double cosine, double sine, const Others* others) {
  const int i = search->resultant.piece;
  const int j = (i + 1) % 3;
  const int k = (i + 2) % 3;
  Sway sway;
  sway.c[i] = cosine * ZERO_COSINE - sine * ZERO_SINE;
  sway.s[i] = cosine * ZERO_SINE + sine * ZERO_COSINE;
  sway.c[j] = others->y[0];
  sway.s[j] = others->y[1];
  sway.c[k] = others->z[0];
  sway.s[k] = others->z[1];
  if (!closeTriangle(search->triangle, &sway)) {
    return -1;
  }
  int n = 0;
  while (n < search->count && !isSame(&search->sways[n], &sway)) {
    n++;
  }
  if (n == CT_CLOSURES_MOST) {
    return -1;
  }
  if (n == search->count) {
    search->sways[n] = sway;
    search->isTaken[n] = false;
    search->count++;
  }
  return n;
}

/* l of a closure, as Arc has it. */
static double placeOf(const Search* search, const Sway* sway) {
  const int i = search->resultant.piece;
  const double c = sway->c[i] * ZERO_COSINE + sway->s[i] * ZERO_SINE;
  const double s = search->sign * (sway->s[i] * ZERO_COSINE - sway->c[i] * ZERO_SINE);
  return c > 0 ? s / (1 + c + s) : (1 - c) / (s + 1 - c);
}

/* Newton's method from about where the root of an arc is, from the likeliest of four branches first. True if it leads
 * to a closure on the arc that no other arc has taken. Closures elsewhere count, too, but leave the arc's root to be
 * found.
 */
static bool closeArc(Search* search, const Arc* arc) {
  const double l = placeOfRoot(arc);
  const double u = 1 - l;
  const double w = search->sign * l;
  const double factor = 1 / (u * u + w * w);
  const double cosine = (u * u - w * w) * factor;
  const double sine = 2 * u * w * factor;
  Others others[4];
  findOthers(&search->resultant, cosine, sine, others);
  for (int attempt = 0; attempt < 4; attempt++) {
    int best = 0;
    for (int i = 1; i < 4; i++) {
      best = others[i].gap < others[best].gap ? i : best;
    }
    const int n = closeFrom(search, cosine, sine, &others[best]);
    if (n >= 0 && !search->isTaken[n]) {
      const double place = placeOf(search, &search->sways[n]);
      if (place >= arc->from - BEYOND && place <= arc->to + BEYOND) {
        search->isTaken[n] = true;
        return true;
      }
    }
    others[best].gap = INFINITY;
  }
  return false;
}

/* True if an arc has no root, or the one that it has is found, or rounding lets us see no more. */
static bool isDone(Search* search, const Arc* arc) {
  if (isUnreal(arc)) {
    return true;
  }
  const double scale = search->resultant.scale;
  double least, most;
  rangeOfArc(arc, &least, &most);
  const int changes = countChanges(arc);
  search->isDoubtful = search->isDoubtful || (changes < 2 && least < NOISE * scale);
  if (changes == 0 || (changes == 1 && closeArc(search, arc))) {
    return true;
  }
  if (arc->depth == DEPTH || most < NOTHING * scale) {
    search->isDoubtful = true;
    return true;
  }
  return false;
}

static void searchHalfCircle(Search* search, double sign) {
  Arc arcs[DEPTH + 1];
  search->sign = sign;
  makeHalfCircle(&search->resultant, sign, &arcs[0]);
  int count = 1;
  while (count > 0) {
    if (isDone(search, &arcs[count - 1])) {
      count--;
    } else {
      halveArc(&arcs[count - 1], &arcs[count]);
      count++;
    }
  }
}

int findSways(const Triangle* triangle, Sway sways[CT_CLOSURES_MOST]) {
  Search search = {.triangle = triangle, .count = 0, .sways = sways};
  /* The turn of another piece has other roots, which rounding hides elsewhere. Closures come in pairs. */
  for (int piece = 0; piece < 3; piece++) {
    makeResultant(triangle, piece, ZERO_COSINE, ZERO_SINE, &search.resultant);
    for (int i = 0; i < search.count; i++) {
      search.isTaken[i] = false;
    }
    search.isDoubtful = false;
    searchHalfCircle(&search, 1);
    searchHalfCircle(&search, -1);
    if (!search.isDoubtful && search.count % 2 == 0) {
      break;
    }
  }
  return search.count;
}
