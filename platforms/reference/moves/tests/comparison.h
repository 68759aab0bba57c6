/* The solver against brute force. */
#ifndef COMPARISON_H_
#define COMPARISON_H_

#include "bruteclosures.h"

typedef struct Comparison {
  int windows;
  int solutions; /* of the solver */
  int known;     /* of brute force */
  int missed;
  int invented;
  int doubtful;    /* neither: brute force has not found it, but it closes the window */
  double worstGap; /* nm, of the solver's solutions */
} Comparison;

/* The largest difference of angles. */
static inline double farthest(const double* a, const double* b) {
  double most = 0;
  for (int k = 0; k < CT_PIVOTS; k++) {
    most = fmax(most, fabs(remainder(a[k] - b[k], 2 * PI)));
  }
  return most;
}

static inline void putTurns(const ctWindow* window, const double* drivers, const double* turns, double* angles) {
  memcpy(angles, drivers, (size_t)window->count * sizeof *angles);
  for (int k = 0; k < CT_PIVOTS; k++) {
    angles[window->pivots[k]] = turns[k];
  }
}

/* |J| of a closure. */
static inline double jacobianAt(const ctWindow* window, const double* drivers, const double* turns) {
  double angles[CT_WINDOW_MOST];
  ctWindow turned;
  putTurns(window, drivers, turns, angles);
  ctTurnWindow(window, angles, &turned);
  return exp(ctComputeLogJacobian(&turned));
}

/* Compares the solutions of one window. Brute force takes finer steps where it does not know all that close it. */
static inline void compareClosures(const ctWindow* window, const double* drivers, int steps, Comparison* sum) {
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  const int count = ctFindClosures(window, drivers, solutions);
  bool isInvented[CT_CLOSURES_MOST] = {false};
  bool isKnown[CT_CLOSURES_MOST] = {false};
  int right = count;
  for (int j = 0; j < count; j++) {
    double angles[CT_WINDOW_MOST];
    putTurns(window, drivers, solutions[j], angles);
    const double gap = gapOf(window, angles, 1);
    isInvented[j] = !(gap < 1e-9);
    for (int i = 0; i < j; i++) {
      isInvented[j] = isInvented[j] || farthest(solutions[i], solutions[j]) < 1e-9;
    }
    right -= isInvented[j] ? 1 : 0;
    sum->worstGap = fmax(sum->worstGap, gap);
  }
  int missed = 0;
  int known = 0;
  Brute brute;
  for (int attempt = 0; attempt < 3 && (attempt == 0 || known < right); attempt++) {
    closeByBrute(window, drivers, steps, &brute);
    steps *= 16;
    missed = 0;
    known = 0;
    memset(isKnown, 0, sizeof isKnown);
    for (int i = 0; i < brute.count; i++) {
      int best = -1;
      double least = 1e-6;
      for (int j = 0; j < count; j++) {
        const double distance = farthest(brute.solutions[i], solutions[j]);
        if (!isKnown[j] && !isInvented[j] && distance < least) {
          least = distance;
          best = j;
        }
      }
      if (best < 0) {
        missed++;
      } else {
        isKnown[best] = true;
        known++;
      }
    }
  }
  for (int j = 0; j < count; j++) {
    if (isInvented[j] || !isKnown[j]) {
      printf("window %d: solution %d is %s, |J| %.3g nm^3\n", sum->windows, j, isInvented[j] ? "invented" : "not known",
             jacobianAt(window, drivers, solutions[j]));
    }
  }
  if (missed > 0) {
    printf("window %d: %d of %d missed; |J| in nm^3", sum->windows, missed, brute.count);
    for (int i = 0; i < brute.count; i++) {
      printf(" %.3g", jacobianAt(window, drivers, brute.solutions[i]));
    }
    printf("\n");
  }
  sum->windows++;
  sum->solutions += count;
  sum->known += brute.count;
  sum->missed += missed;
  sum->invented += count - right;
  sum->doubtful += right - known;
}

#endif /* COMPARISON_H_ */
