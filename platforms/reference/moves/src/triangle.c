#include "triangle.h"

#include <stddef.h>

#include "arctangent.h"
#include "turning.h"

/* A triangle is flat if its height is below this part of its longest side. There, J is zero. */
#define FLAT 1e-7

/* Two axes are parallel if the sine of their angle is below this. */
#define PARALLEL 1e-7

static int next(int corner) {
  return corner == 2 ? 0 : corner + 1;
}

bool isWindow(const ctWindow* w) {
  if (w == NULL || w->count < CT_PIVOTS || w->count > CT_WINDOW_MOST) {
    return false;
  }
  for (int k = 0; k < CT_PIVOTS; k++) {
    const int least = k == 0 ? 0 : w->pivots[k - 1] + 1;
    if (w->pivots[k] < least || w->pivots[k] >= w->count || (k % 2 == 1 && w->pivots[k] != least)) {
      return false;
    }
  }
  return true;
}

/* Turns by the drivers first <= i < last, about points relative to an origin. */
static bool turnDrivers(const ctWindow* w, const double* angles, const double* origin, int first, int last,
                        Turning* turning) {
  bool isTurned = false;
  for (int i = first; i < last; i++) {
    if (angles[i] != 0) {
      double point[3];
      subtract(w->points[i], origin, point);
      const Turning turn = turningAbout(point, w->axes[i], angles[i]);
      turnFirst(turning, &turn);
      isTurned = true;
    }
  }
  return isTurned;
}

/* The lengths of the sides give the shape. */
static bool shapeTriangle(Triangle* t) {
  const double* l = t->sides;
  /* The longest side is the base: the foot of the height lies on it. */
  const int i = l[0] >= l[1] ? (l[0] >= l[2] ? 0 : 2) : (l[1] >= l[2] ? 1 : 2);
  const int j = next(i);
  const int k = next(j);
  const double foot = 0.5 * (l[i] + (l[j] - l[k]) * (l[j] + l[k]) / l[i]);
  const double square = (l[j] - foot) * (l[j] + foot);
  if (!(l[j] > 0 && l[k] > 0 && square > FLAT * FLAT * l[i] * l[i])) {
    return false;
  }
  const double height = sqrt(square);
  t->tangent[i][0] = -1;
  t->tangent[i][1] = 0;
  t->tangent[j][0] = foot / l[j];
  t->tangent[j][1] = -height / l[j];
  t->tangent[k][0] = (l[i] - foot) / l[k];
  t->tangent[k][1] = height / l[k];
  for (int corner = 0; corner < 3; corner++) {
    const double* a = t->tangent[corner == 0 ? 2 : corner - 1];
    const double* b = t->tangent[corner];
    t->cosines[corner] = a[0] * b[0] + a[1] * b[1];
    t->sines[corner] = a[0] * b[1] - a[1] * b[0];
  }
  return true;
}

/* Unit vectors along the side, across it in the plane, and along the normal that is nearest to a given vector. */
static bool framePiece(const double side[3], double length, const double normal[3], double frame[3][3]) {
  for (int k = 0; k < 3; k++) {
    frame[0][k] = side[k] / length;
    frame[2][k] = normal[k];
  }
  addScaled(frame[2], -dot(normal, frame[0]), frame[0]);
  const double square = dot(frame[2], frame[2]);
  if (!(square > FLAT * FLAT * dot(normal, normal))) {
    return false;
  }
  scale(frame[2], 1 / sqrt(square));
  cross(frame[2], frame[0], frame[1]);
  return true;
}

/* y may be x. */
static void inFrame(double frame[3][3], const double x[3], double y[3]) {
  const double l = dot(frame[0], x);
  const double p = dot(frame[1], x);
  const double n = dot(frame[2], x);
  y[0] = l;
  y[1] = p;
  y[2] = n;
}

bool makeTriangle(const ctWindow* w, const double* angles, Triangle* t) {
  if (!isWindow(w) || angles == NULL) {
    return false;
  }
  const double* origin = w->points[w->pivots[0]];
  double points[3][3];
  for (int k = 0; k < 3; k++) {
    subtract(w->points[w->pivots[2 * k]], origin, points[k]);
    const double* a = w->axes[w->pivots[2 * k]];
    const double* b = w->axes[w->pivots[2 * k + 1]];
    double across[3];
    cross(a, b, across);
    t->angles[k] = dot(a, b);
    if (!(dot(across, across) > PARALLEL * PARALLEL)) {
      return false;
    }
  }
  double normal[3];
  cross(points[1], points[2], normal);
  double sides[3][3];
  double normals[3][3];
  for (int k = 0; k < 3; k++) {
    const int to = next(k);
    const int first = w->pivots[2 * k + 1] + 1;
    Turning turning = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    bool isTurned = turnDrivers(w, angles, origin, first, to == 0 ? w->count : w->pivots[2 * to], &turning);
    if (to == 0) {
      isTurned = turnDrivers(w, angles, origin, 0, w->pivots[0], &turning) || isTurned;
    }
    const double* a = w->axes[w->pivots[2 * to]];
    const double* b = w->axes[w->pivots[2 * to + 1]];
    Corner* end = &t->before[to];
    for (int i = 0; i < 3; i++) {
      end->first[i] = a[i];
      end->second[i] = b[i];
      sides[k][i] = points[to][i];
      normals[k][i] = normal[i];
    }
    if (isTurned) {
      turnDirection(&turning, a, end->first);
      turnDirection(&turning, b, end->second);
      turnPoint(&turning, points[to], sides[k]);
      turnDirection(&turning, normal, normals[k]);
      addScaled(normals[k], 1, normal); /* the direction halfway between that of the start and that of the end */
    }
    addScaled(sides[k], -1, points[k]);
    t->sides[k] = sqrt(dot(sides[k], sides[k]));
  }
  if (!shapeTriangle(t)) {
    return false;
  }
  for (int k = 0; k < 3; k++) {
    double frame[3][3];
    if (!framePiece(sides[k], t->sides[k], normals[k], frame)) {
      return false;
    }
    Corner* end = &t->before[next(k)];
    inFrame(frame, end->first, end->first);
    inFrame(frame, end->second, end->second);
    inFrame(frame, w->axes[w->pivots[2 * k]], t->after[k].first);
    inFrame(frame, w->axes[w->pivots[2 * k + 1]], t->after[k].second);
  }
  return true;
}

/* The residuals of the three equations, and their derivatives by the turns of the pieces before and after the corner.
 */
typedef struct Slopes {
  double gaps[3];
  double before[3];
  double after[3];
} Slopes;

static void slopesOf(const Triangle* t, const Sway* sway, Slopes* slopes) {
  for (int k = 0; k < 3; k++) {
    const int i = k == 0 ? 2 : k - 1;
    const double* a = t->before[k].first;
    const double* b = t->after[k].second;
    const double ap = a[1] * sway->c[i] - a[2] * sway->s[i];
    const double an = a[1] * sway->s[i] + a[2] * sway->c[i];
    const double bp = b[1] * sway->c[k] - b[2] * sway->s[k];
    const double bn = b[1] * sway->s[k] + b[2] * sway->c[k];
    const double c = t->cosines[k];
    const double s = t->sines[k];
    /* The first axis along and across the side after the corner, and the second along and across that before it. */
    const double al = c * a[0] + s * ap;
    const double aq = c * ap - s * a[0];
    const double bq = s * b[0] + c * bp;
    slopes->gaps[k] = al * b[0] + aq * bp + an * bn - t->angles[k];
    slopes->before[k] = ap * bn - an * bq;
    slopes->after[k] = an * bp - aq * bn;
  }
}

/* Each equation has two of the three unknowns. */
static double determinant(const Slopes* s) {
  return s->after[0] * s->after[1] * s->after[2] + s->before[0] * s->before[1] * s->before[2];
}

/* One in a thousand closures takes more steps; the longest, in rad. */
#define STEPS 16
#define LONGEST_STEP 0.5

/* The square of a step so short that only rounding remains after it. */
#define LAST_STEP 1e-16

bool closeTriangle(const Triangle* t, Sway* sway) {
  for (int step = 0; step < STEPS; step++) {
    Slopes slopes;
    slopesOf(t, sway, &slopes);
    const double* a = slopes.before;
    const double* b = slopes.after;
    const double* r = slopes.gaps;
    const double inverse = -1 / determinant(&slopes);
    double turns[3] = {(r[0] * b[1] * b[2] + a[0] * (r[1] * a[2] - b[1] * r[2])) * inverse,
                       (r[1] * b[2] * b[0] + a[1] * (r[2] * a[0] - b[2] * r[0])) * inverse,
                       (r[2] * b[0] * b[1] + a[2] * (r[0] * a[1] - b[0] * r[1])) * inverse};
    const double square = dot(turns, turns);
    if (!(square < INFINITY)) {
      return false;
    }
    if (square > LONGEST_STEP * LONGEST_STEP) {
      scale(turns, LONGEST_STEP / sqrt(square));
    }
    for (int k = 0; k < 3; k++) {
      /* A rotation whose angle differs from the step by a twelfth of its third power: no trigonometric function. */
      const double half = 0.5 * turns[k];
      const double factor = 2 / (1 + half * half);
      const double c = factor - 1;
      const double s = factor * half;
      const double former = sway->c[k];
      sway->c[k] = c * former - s * sway->s[k];
      sway->s[k] = c * sway->s[k] + s * former;
    }
    if (square < LAST_STEP) {
      return true;
    }
  }
  return false;
}

/* A direction that a piece has, in the plane's frame, after the piece has turned. */
static void placeAxis(const Triangle* t, const Sway* sway, int piece, const double axis[3], double placed[3]) {
  const double* tangent = t->tangent[piece];
  const double across = axis[1] * sway->c[piece] - axis[2] * sway->s[piece];
  placed[0] = axis[0] * tangent[0] - across * tangent[1];
  placed[1] = axis[0] * tangent[1] + across * tangent[0];
  placed[2] = axis[1] * sway->s[piece] + axis[2] * sway->c[piece];
}

/* The angle about a unit vector from one direction to another. */
static double angleAbout(const double axis[3], const double from[3], const double to[3]) {
  double across[3];
  cross(from, to, across);
  return arctangent2(dot(axis, across), dot(from, to) - dot(axis, from) * dot(axis, to));
}

bool turnsOfTriangle(const Triangle* t, const Sway* sway, double turns[CT_PIVOTS]) {
  bool areNumbers = true;
  for (int k = 0; k < 3; k++) {
    const int i = k == 0 ? 2 : k - 1;
    Corner before, after;
    placeAxis(t, sway, i, t->before[k].first, before.first);
    placeAxis(t, sway, i, t->before[k].second, before.second);
    placeAxis(t, sway, k, t->after[k].first, after.first);
    placeAxis(t, sway, k, t->after[k].second, after.second);
    /* The first turn takes the second axis along; the second turns what lies behind, as the first axis would if it were
     * part of it. */
    turns[2 * k] = angleAbout(before.first, before.second, after.second);
    turns[2 * k + 1] = angleAbout(after.second, before.first, after.first);
    areNumbers = areNumbers && isfinite(turns[2 * k]) && isfinite(turns[2 * k + 1]);
  }
  return areNumbers;
}
