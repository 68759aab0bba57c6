#include "closing.h"

#include <stddef.h>
#include <string.h>

#define HALF_TURN 3.141592653589793238462643383280

/* rad. A motion that turns by less is no product of two half turns within rounding; one in 1e10 does. */
#define LEAST_TURN 1e-3

/* The window of the closing joints as they were given. */
static void makeWindow(const LoopShape* s, const LoopSteps* steps, ctWindow* window) {
  window->count = steps->closingLast - steps->closingFirst + 1;
  for (int i = 0; i < window->count; i++) {
    memcpy(window->points[i], s->points[steps->closingFirst + i], sizeof window->points[i]);
    memcpy(window->axes[i], s->axes[steps->closingFirst + i], sizeof window->axes[i]);
  }
  for (int k = 0; k < CT_PIVOTS; k++) {
    window->pivots[k] = steps->pivots[k] - steps->closingFirst;
    if (k % 2 == 1) {
      memcpy(window->points[window->pivots[k]], window->points[window->pivots[k] - 1], sizeof window->points[0]);
    }
  }
}

/* c = a^-1 b */
static void between(const Turning* a, const Turning* b, Turning* c) {
  double t[3];
  subtract(b->t, a->t, t);
  for (int i = 0; i < 3; i++) {
    c->t[i] = 0;
    for (int j = 0; j < 3; j++) {
      c->r[i][j] = a->r[0][i] * b->r[0][j] + a->r[1][i] * b->r[1][j] + a->r[2][i] * b->r[2][j];
      c->t[i] += a->r[j][i] * t[j];
    }
  }
}

/* The axis of a rotation and its angle, in [0, pi], from the quaternion's largest component (Shepperd 1978). */
static double axisOf(const double r[3][3], double axis[3]) {
  const double squares[4] = {1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
                             1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
  int best = 0;
  for (int k = 1; k < 4; k++) {
    best = squares[k] > squares[best] ? k : best;
  }
  const double largest = sqrt(squares[best]), f = 1 / largest;
  const double q[4][4] = {{largest, (r[2][1] - r[1][2]) * f, (r[0][2] - r[2][0]) * f, (r[1][0] - r[0][1]) * f},
                          {(r[2][1] - r[1][2]) * f, largest, (r[1][0] + r[0][1]) * f, (r[0][2] + r[2][0]) * f},
                          {(r[0][2] - r[2][0]) * f, (r[1][0] + r[0][1]) * f, largest, (r[2][1] + r[1][2]) * f},
                          {(r[1][0] - r[0][1]) * f, (r[0][2] + r[2][0]) * f, (r[2][1] + r[1][2]) * f, largest}};
  const double sign = q[best][0] < 0 ? -1 : 1;
  const double sine = sqrt(dot(&q[best][1], &q[best][1]));
  for (int k = 0; k < 3; k++) {
    axis[k] = sign * q[best][k + 1] / sine;
  }
  return 2 * atan2(sine, sign * q[best][0]);
}

/* Adds a half turn about a line to a window. */
static void addHalfTurn(ctWindow* window, double* angles, const double point[3], const double axis[3]) {
  memcpy(window->points[window->count], point, sizeof window->points[0]);
  memcpy(window->axes[window->count], axis, sizeof window->axes[0]);
  angles[window->count++] = HALF_TURN;
}

/* Adds two half turns whose product is a motion: their axes meet that of the motion at right angles, half its shift and
 * half its turn apart. None, if nothing moves. */
static bool addMotion(ctWindow* window, double* angles, const Turning* motion) {
  double u[3], first[3], second[3], point[3], across[3], side[3] = {0};
  const double turn = axisOf(motion->r, u);
  if (!(turn >= LEAST_TURN)) {
    return turn == 0 && dot(motion->t, motion->t) == 0;
  }
  const double shift = dot(u, motion->t);
  memcpy(point, motion->t, sizeof point);
  addScaled(point, -shift, u);
  cross(u, point, across);
  scale(point, 0.5);
  addScaled(point, 0.5 / tan(0.5 * turn), across);
  const int least = fabs(u[0]) < fabs(u[1]) ? (fabs(u[0]) < fabs(u[2]) ? 0 : 2) : (fabs(u[1]) < fabs(u[2]) ? 1 : 2);
  side[least] = 1;
  cross(u, side, second);
  scale(second, 1 / sqrt(dot(second, second)));
  cross(u, second, side);
  const Angle half = angleOfAny(0.5 * turn);
  for (int k = 0; k < 3; k++) {
    first[k] = half.cosine * second[k] + half.sine * side[k];
  }
  double shifted[3];
  memcpy(shifted, point, sizeof shifted);
  addScaled(shifted, 0.5 * shift, u);
  addHalfTurn(window, angles, shifted, first);
  addHalfTurn(window, angles, point, second);
  return true;
}

int findJoins(const LoopShape* s, const LoopSteps* steps, const Turning* head, const Turning* tail, const double* turns,
              double solutions[CT_CLOSURES_MOST][CT_PIVOTS]) {
  ctWindow window;
  double angles[CT_WINDOW_MOST];
  Turning motion;
  makeWindow(s, steps, &window);
  memcpy(angles, turns + steps->closingFirst, (size_t)window.count * sizeof *angles);
  between(tail, head, &motion);
  return addMotion(&window, angles, &motion) ? ctFindClosures(&window, angles, solutions) : 0;
}

double logJacobianOf(const LoopShape* s, const LoopSteps* steps, const double* turns) {
  ctWindow window;
  makeWindow(s, steps, &window);
  ctTurnWindow(&window, turns + steps->closingFirst, &window);
  return ctComputeLogJacobian(&window);
}
