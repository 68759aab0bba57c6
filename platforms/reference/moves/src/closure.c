#include "ctclosure.h"

/* Placeholders until the solver lands in this folder. */

void ctTurnWindow(const ctWindow* window, const double* angles, ctWindow* turned) {
  (void)angles;
  *turned = *window;
}

double ctComputeLogJacobian(const ctWindow* window) {
  (void)window;
  return 0;
}

bool ctCloseNear(const ctWindow* window, double* angles) {
  (void)window;
  (void)angles;
  return false;
}

int ctFindClosures(const ctWindow* window, const double* angles, double solutions[CT_CLOSURES_MOST][CT_PIVOTS]) {
  (void)window;
  (void)angles;
  (void)solutions;
  return 0;
}
