/* All ways to close a window, by brute force in long double, independent of the solver: the first pivot is turned
 * through the whole circle. The second can bring the second point to its distance from the third in two ways; the next
 * two can bring the third point to its place in two ways; and for each of these four branches the last two axes meet
 * at an angle that is right or wrong. */
#ifndef BRUTECLOSURES_H_
#define BRUTECLOSURES_H_

#include "randomwindow.h"

#define BRUTE_MOST 32
#define BRUTE_ENDS 64 /* points where a branch ends within a step */

/* The window after its drivers have turned. What lies behind a pivot is as it is when no pivot turns. */
typedef struct Brute {
  Real first[3], second[3]; /* axes at the first point */
  Real firstPoint[3], thirdPoint[3];
  Real toSecond[3], a2[3], b2[3]; /* from the first point to the second; axes there */
  Real toThird[3], a3[3], b3[3];  /* the same of the third, seen from the second */
  Real a3Tail[3], b3Tail[3];      /* axes of the third point as the tail has them */
  Real cosine;                    /* of the angle that they have */
  int steps;
  int count;
  double solutions[BRUTE_MOST][CT_PIVOTS];
} Brute;

/* One branch at one turn of the first pivot. */
typedef struct Branch {
  bool isReal[2]; /* there is a turn of the second pivot, and of the third */
  Real gap;
  Real turns[CT_PIVOTS];
} Branch;

static inline Real angleReal(const Real axis[3], const Real from[3], const Real to[3]) {
  Real across[3];
  crossReal(axis, from, across);
  return atan2l(dotReal(across, to), dotReal(from, to) - dotReal(axis, from) * dotReal(axis, to));
}

/* The turn x about an axis after which the part of `moved` along `target` is `wanted`: one of two, or, if there is
 * none, that which comes nearest. */
static inline bool turnTo(const Real axis[3], const Real moved[3], const Real target[3], Real wanted, int which,
                          Real* turn) {
  Real across[3];
  crossReal(axis, moved, across);
  const Real along = dotReal(axis, moved) * dotReal(axis, target);
  const Real c = dotReal(moved, target) - along;
  const Real s = dotReal(across, target);
  const Real ratio = (wanted - along) / sqrtl(c * c + s * s);
  const bool isReal = fabsl(ratio) <= 1;
  const Real half = isReal ? acosl(ratio) : ratio > 0 ? 0 : (Real)PI;
  *turn = atan2l(s, c) + (which ? half : -half);
  return isReal;
}

static inline Branch branchAt(const Brute* b, Real turn, int which) {
  Branch branch = {{true, true}, 0, {turn}};
  Real second[3], arm[3], toThird[3], a2[3], b2[3], a3[3], b3[3], away[3], left[3];
  memcpy(second, b->second, sizeof second);
  memcpy(arm, b->toSecond, sizeof arm);
  memcpy(toThird, b->toThird, sizeof toThird);
  memcpy(a2, b->a2, sizeof a2);
  memcpy(b2, b->b2, sizeof b2);
  memcpy(a3, b->a3, sizeof a3);
  memcpy(b3, b->b3, sizeof b3);
  Real* const behind[6] = {arm, a2, b2, toThird, a3, b3};
  turnReal(b->first, turn, second);
  for (int i = 0; i < 6; i++) {
    turnReal(b->first, turn, behind[i]);
  }
  for (int k = 0; k < 3; k++) {
    away[k] = b->thirdPoint[k] - b->firstPoint[k];
  }
  /* |away - arm|^2 = |toThird|^2 */
  const Real wanted = (dotReal(away, away) + dotReal(arm, arm) - dotReal(toThird, toThird)) / 2;
  branch.isReal[0] = turnTo(second, arm, away, wanted, which & 1, &branch.turns[1]);
  for (int i = 0; i < 6; i++) {
    turnReal(second, branch.turns[1], behind[i]);
  }
  for (int k = 0; k < 3; k++) {
    left[k] = away[k] - arm[k];
  }
  branch.isReal[1] = turnTo(a2, b2, left, dotReal(b2, toThird), which >> 1, &branch.turns[2]);
  for (int i = 2; i < 6; i++) {
    turnReal(a2, branch.turns[2], behind[i]);
  }
  branch.turns[3] = angleReal(b2, toThird, left);
  for (int i = 3; i < 6; i++) {
    turnReal(b2, branch.turns[3], behind[i]);
  }
  branch.gap = dotReal(a3, b->b3Tail) - b->cosine;
  branch.turns[4] = angleReal(a3, b3, b->b3Tail);
  branch.turns[5] = angleReal(b->b3Tail, a3, b->a3Tail);
  return branch;
}

static inline void foundBrute(Brute* b, const Branch* branch) {
  if (b->count == BRUTE_MOST) {
    printf("more solutions than there can be\n");
    exit(1);
  }
  for (int k = 0; k < CT_PIVOTS; k++) {
    b->solutions[b->count][k] = (double)remainderl(branch->turns[k], 2 * acosl(-1));
  }
  b->count++;
}

/* Turns of the first pivot, from x = 0 to 1 where a branch ends at `from`, so that it is smooth in x there. */
typedef struct Stretch {
  Real from, to;
  bool isEnd;
} Stretch;

static inline Branch branchOn(const Brute* b, const Stretch* stretch, Real x, int which) {
  return branchAt(b, stretch->from + (stretch->to - stretch->from) * (stretch->isEnd ? x * x : x), which);
}

static inline void bisectBrute(Brute* b, const Stretch* stretch, Real from, Real to, int which) {
  const bool isNegative = branchOn(b, stretch, from, which).gap < 0;
  for (int i = 0; i < 70; i++) {
    const Real middle = (from + to) / 2;
    if ((branchOn(b, stretch, middle, which).gap < 0) == isNegative) {
      from = middle;
    } else {
      to = middle;
    }
  }
  const Branch branch = branchOn(b, stretch, (from + to) / 2, which);
  foundBrute(b, &branch);
}

/* The root between two points of a branch, or two roots where it comes near zero between them. */
static inline void lookBetween(Brute* b, const Stretch* stretch, Real from, Real to, Real gapFrom, Real gapTo,
                               int which) {
  if ((gapFrom < 0) != (gapTo < 0)) {
    bisectBrute(b, stretch, from, to, which);
    return;
  }
  const Real sign = gapFrom < 0 ? -1 : 1;
  const Real h = (to - from) / 64;
  if (sign * (branchOn(b, stretch, from + h, which).gap - gapFrom) >= 0 ||
      sign * (branchOn(b, stretch, to - h, which).gap - gapTo) >= 0) {
    return;
  }
  /* It has a least distance from zero between them. */
  Real low = from, high = to;
  for (int i = 0; i < 60; i++) {
    const Real x = low + (high - low) * 0.4L, y = low + (high - low) * 0.6L;
    const Real atX = sign * branchOn(b, stretch, x, which).gap, atY = sign * branchOn(b, stretch, y, which).gap;
    if (atX < 0 || atY < 0) {
      const Real middle = atX < 0 ? x : y;
      bisectBrute(b, stretch, from, middle, which);
      bisectBrute(b, stretch, middle, to, which);
      return;
    }
    low = atX > atY ? x : low;
    high = atX > atY ? high : y;
  }
}

static inline bool isRealBranch(const Branch* branch) {
  return branch->isReal[0] && branch->isReal[1];
}

static inline void setUpBrute(const ctWindow* w, const double* angles, int steps, Brute* b) {
  Real points[CT_WINDOW_MOST][3], axes[CT_WINDOW_MOST][3];
  /* Drivers turn what lies behind them; pivots do not turn. */
  for (int i = 0; i < w->count; i++) {
    Real end[3];
    for (int k = 0; k < 3; k++) {
      points[i][k] = w->points[i][k];
      end[k] = (Real)w->points[i][k] + w->axes[i][k];
    }
    for (int j = i - 1; j >= 0; j--) {
      turnPointReal(w->points[j], w->axes[j], angles[j], points[i]);
      turnPointReal(w->points[j], w->axes[j], angles[j], end);
    }
    for (int k = 0; k < 3; k++) {
      axes[i][k] = end[k] - points[i][k];
    }
  }
  /* The third point as the tail has it: drivers behind it turn back. */
  const int last = w->pivots[5];
  const double* p = w->points[last];
  Real tail[3][3];
  for (int k = 0; k < 3; k++) {
    tail[0][k] = p[k];
    tail[1][k] = (Real)p[k] + w->axes[w->pivots[4]][k];
    tail[2][k] = (Real)p[k] + w->axes[last][k];
  }
  for (int j = last + 1; j < w->count; j++) {
    for (int n = 0; n < 3; n++) {
      turnPointReal(w->points[j], w->axes[j], -(Real)angles[j], tail[n]);
    }
  }
  const int* v = w->pivots;
  for (int k = 0; k < 3; k++) {
    b->first[k] = axes[v[0]][k];
    b->second[k] = axes[v[1]][k];
    b->a2[k] = axes[v[2]][k];
    b->b2[k] = axes[v[3]][k];
    b->a3[k] = axes[v[4]][k];
    b->b3[k] = axes[v[5]][k];
    b->firstPoint[k] = points[v[0]][k];
    b->toSecond[k] = points[v[2]][k] - points[v[0]][k];
    b->toThird[k] = points[v[4]][k] - points[v[2]][k];
    b->thirdPoint[k] = tail[0][k];
    b->a3Tail[k] = tail[1][k] - tail[0][k];
    b->b3Tail[k] = tail[2][k] - tail[0][k];
  }
  Real* const units[8] = {b->first, b->second, b->a2, b->b2, b->a3, b->b3, b->a3Tail, b->b3Tail};
  for (int n = 0; n < 8; n++) {
    const Real norm = sqrtl(dotReal(units[n], units[n]));
    for (int k = 0; k < 3; k++) {
      units[n][k] /= norm;
    }
  }
  b->cosine = dotReal(b->a3, b->b3);
  b->steps = steps;
  b->count = 0;
}

/* Finds all closures with `steps` steps of the first pivot. */
static inline void closeByBrute(const ctWindow* window, const double* angles, int steps, Brute* b) {
  setUpBrute(window, angles, steps, b);
  const Real start = 0.1234567L; /* the present turn, 0, is on no step */
  Branch former[4];
  for (int which = 0; which < 4; which++) {
    former[which] = branchAt(b, start, which);
  }
  const Real circle = 2 * acosl(-1);
  for (int step = 1; step <= steps; step++) {
    const Real from = start + circle * (step - 1) / steps;
    const Real to = start + circle * step / steps;
    for (int which = 0; which < 4; which++) {
      const Branch now = branchAt(b, to, which);
      const bool was = isRealBranch(&former[which]);
      const bool is = isRealBranch(&now);
      if (was && is) {
        const Stretch stretch = {from, to, false};
        lookBetween(b, &stretch, 0, 1, former[which].gap, now.gap, which);
      } else if (was || is) {
        /* Where it ends, another one begins; both are smooth in the root of the distance from there. */
        Real real = was ? from : to;
        Real other = was ? to : from;
        const Real end = real;
        for (int i = 0; i < 70; i++) {
          const Real middle = (real + other) / 2;
          const Branch branch = branchAt(b, middle, which);
          *(isRealBranch(&branch) ? &real : &other) = middle;
        }
        const Stretch stretch = {real, end, true};
        Real gap = branchOn(b, &stretch, 0, which).gap;
        for (int i = 0; i < BRUTE_ENDS; i++) {
          const Real x = (Real)i / BRUTE_ENDS, y = (Real)(i + 1) / BRUTE_ENDS;
          const Real next = branchOn(b, &stretch, y, which).gap;
          lookBetween(b, &stretch, x, y, gap, next, which);
          gap = next;
        }
      }
      former[which] = now;
    }
  }
}

#endif /* BRUTECLOSURES_H_ */
