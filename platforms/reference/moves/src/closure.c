#include "ctclosure.h"

#include <stddef.h>

#include "search.h"
#include "triangle.h"
#include "turning.h"

void ctTurnWindow(const ctWindow* window, const double* angles, ctWindow* turned) {
  if (window == NULL || angles == NULL || turned == NULL) {
    return;
  }
  if (window->count < 1 || window->count > CT_WINDOW_MOST) {
    *turned = *window;
    return;
  }
  const double* origin = window->points[0];
  Turning behind = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
  ctWindow result = *window;
  for (int i = 0; i < window->count; i++) {
    double point[3];
    subtract(window->points[i], origin, point);
    const Turning turn = turningAbout(point, window->axes[i], angles[i]);
    if (i > 0) {
      turnPoint(&behind, point, point);
      for (int k = 0; k < 3; k++) {
        result.points[i][k] = origin[k] + point[k];
      }
      turnDirection(&behind, window->axes[i], result.axes[i]);
    }
    turnFirst(&behind, &turn);
  }
  *turned = result;
}

double ctComputeLogJacobian(const ctWindow* w) {
  if (!isWindow(w)) {
    return NAN;
  }
  /* The determinant by columns, of pairs of axes that meet in a point: of each pair only the cross product is left. */
  double normals[3][3];
  double sides[3][3];
  for (int k = 0; k < 3; k++) {
    cross(w->axes[w->pivots[2 * k]], w->axes[w->pivots[2 * k + 1]], normals[k]);
    subtract(w->points[w->pivots[k == 2 ? 0 : 2 * k + 2]], w->points[w->pivots[2 * k]], sides[k]);
  }
  const double after = dot(normals[0], sides[0]) * dot(normals[1], sides[1]) * dot(normals[2], sides[2]);
  const double before = dot(normals[0], sides[2]) * dot(normals[1], sides[0]) * dot(normals[2], sides[1]);
  return log(fabs(after - before));
}

bool ctCloseNear(const ctWindow* window, double* angles) {
  Triangle triangle;
  Sway sway = {{1, 1, 1}, {0, 0, 0}};
  double turns[CT_PIVOTS];
  if (!makeTriangle(window, angles, &triangle) || !closeTriangle(&triangle, &sway) ||
      !turnsOfTriangle(&triangle, &sway, turns)) {
    return false;
  }
  for (int k = 0; k < CT_PIVOTS; k++) {
    angles[window->pivots[k]] = turns[k];
  }
  return true;
}

int ctFindClosures(const ctWindow* window, const double* angles, double solutions[CT_CLOSURES_MOST][CT_PIVOTS]) {
  Triangle triangle;
  if (solutions == NULL || !makeTriangle(window, angles, &triangle)) {
    return 0;
  }
  Sway sways[CT_CLOSURES_MOST];
  const int found = findSways(&triangle, sways);
  int count = 0;
  for (int i = 0; i < found; i++) {
    count += turnsOfTriangle(&triangle, &sways[i], solutions[count]) ? 1 : 0;
  }
  return count;
}
