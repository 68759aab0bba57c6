/* Spheres as volumes. */
#ifndef BALL_H_
#define BALL_H_

#include <math.h>
#include <stdbool.h>

#include "rigid.h"

typedef struct Ball {
  double centre[3];
  double radius;
} Ball;

static inline Ball ballOfSphere(double radius) {
  return (Ball){{0, 0, 0}, radius};
}

/* b is moved by `motion`. */
static inline bool ballsOverlap(const Ball* a, const Ball* b, const Rigid* motion) {
  double centre[3];
  rigidApply(motion, b->centre, centre);
  const double sum = a->radius + b->radius;
  return squaredDistance(a->centre, centre) <= sum * sum;
}

/* The smallest ball around two, b moved by `motion`. */
static inline Ball ballOfPair(const Ball* a, const Ball* b, const Rigid* motion) {
  Ball moved = {.radius = b->radius};
  rigidApply(motion, b->centre, moved.centre);
  const double distance = sqrt(squaredDistance(a->centre, moved.centre));
  if (distance + b->radius <= a->radius) {
    return *a;
  }
  if (distance + a->radius <= b->radius) {
    return moved;
  }
  Ball ball = {.radius = 0.5 * (distance + a->radius + b->radius) * (1 + 1e-15)};
  const double share = (ball.radius - a->radius) / distance;
  for (int k = 0; k < 3; k++) {
    ball.centre[k] = a->centre[k] + share * (moved.centre[k] - a->centre[k]);
  }
  return ball;
}

#endif /* BALL_H_ */
