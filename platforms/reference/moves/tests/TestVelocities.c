/* Velocities that turn with bodies: what stays, and that the way back undoes them. */
#include "ctvelocities.h"

#include <stdint.h>

#include "../../chaintree/tests/check.h"

enum { BODIES = 7, PARTICLES = 60 };

static uint64_t chance = 88172645463325252u;

static double draw(void) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (double)(chance >> 11) * 0x1p-53 - 0.5;
}

/* By a random unit quaternion. */
static void drawRotation(double r[9]) {
  double q[4];
  double norm = 0;
  for (int i = 0; i < 4; i++) {
    q[i] = draw();
    norm += q[i] * q[i];
  }
  for (int i = 0; i < 4; i++) {
    q[i] /= sqrt(norm);
  }
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double rotation[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                              2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                              2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  memcpy(r, rotation, sizeof rotation);
}

typedef struct Bodies {
  int bodyOf[PARTICLES];
  double masses[PARTICLES];
  double before[BODIES][9];
  double after[BODIES][9];
  double velocities[3 * PARTICLES];
} Bodies;

static Bodies drawBodies(void) {
  Bodies bodies;
  for (int i = 0; i < PARTICLES; i++) {
    bodies.bodyOf[i] = i % BODIES;
    bodies.masses[i] = 1 + 16 * (draw() + 0.5);
  }
  for (int b = 0; b < BODIES; b++) {
    drawRotation(bodies.before[b]);
    drawRotation(bodies.after[b]);
  }
  for (int i = 0; i < 3 * PARTICLES; i++) {
    bodies.velocities[i] = draw();
  }
  return bodies;
}

static double kineticEnergy(const Bodies* bodies) {
  double energy = 0;
  for (int i = 0; i < 3 * PARTICLES; i++) {
    energy += 0.5 * bodies->masses[i / 3] * bodies->velocities[i] * bodies->velocities[i];
  }
  return energy;
}

static void momentum(const Bodies* bodies, double p[3]) {
  p[0] = p[1] = p[2] = 0;
  for (int i = 0; i < 3 * PARTICLES; i++) {
    p[i % 3] += bodies->masses[i / 3] * bodies->velocities[i];
  }
}

/* Turns `before` to `after`. */
static void turn(Bodies* bodies, bool keepsMomentum) {
  double turns[BODIES][9];
  memcpy(turns, bodies->after, sizeof turns);
  CHECK(ctFindTurns(BODIES, bodies->before, turns));
  if (keepsMomentum) {
    ctTurnVelocitiesKeepingMomentum(PARTICLES, bodies->bodyOf, turns, bodies->masses, bodies->velocities);
  } else {
    ctTurnVelocities(PARTICLES, bodies->bodyOf, turns, bodies->velocities);
  }
}

static void turnBack(Bodies* bodies, bool keepsMomentum) {
  double kept[BODIES][9];
  memcpy(kept, bodies->before, sizeof kept);
  memcpy(bodies->before, bodies->after, sizeof kept);
  memcpy(bodies->after, kept, sizeof kept);
  turn(bodies, keepsMomentum);
}

/* Kinetic energy stays, momentum if it is to, and the move back undoes all. */
static void testWhatStays(void) {
  for (int round = 0; round < 200; round++) {
    const bool keepsMomentum = round % 2 == 1;
    const Bodies start = drawBodies();
    Bodies bodies = start;
    turn(&bodies, keepsMomentum);
    CHECK_NEAR(kineticEnergy(&bodies) / kineticEnergy(&start), 1, 1e-13);
    double p0[3];
    double p1[3];
    momentum(&start, p0);
    momentum(&bodies, p1);
    if (keepsMomentum) {
      for (int k = 0; k < 3; k++) {
        CHECK_NEAR(p1[k], p0[k], 1e-12);
      }
    } else {
      CHECK(fabs(p1[0] - p0[0]) > 1e-6);
    }
    turnBack(&bodies, keepsMomentum);
    for (int i = 0; i < 3 * PARTICLES; i++) {
      CHECK_NEAR(bodies.velocities[i], start.velocities[i], 1e-12);
    }
  }
}

/* All bodies as one, by half a turn too: then keeping momentum means turning what is relative to the drift. */
static void testOneTurnForAll(void) {
  Bodies bodies = drawBodies();
  for (int b = 0; b < BODIES; b++) {
    const double half[9] = {-1, 0, 0, 0, -1, 0, 0, 0, 1};
    const double none[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    memcpy(bodies.before[b], none, sizeof none);
    memcpy(bodies.after[b], half, sizeof half);
  }
  const Bodies start = bodies;
  double mass = 0;
  double p[3];
  momentum(&start, p);
  for (int i = 0; i < PARTICLES; i++) {
    mass += start.masses[i];
  }
  turn(&bodies, true);
  for (int i = 0; i < 3 * PARTICLES; i++) {
    const double drift = p[i % 3] / mass;
    const double relative = start.velocities[i] - drift;
    CHECK_NEAR(bodies.velocities[i], drift + (i % 3 == 2 ? relative : -relative), 1e-13);
  }
}

/* Velocities relative to each other along a line that two bodies turn about, and those in a body, turn with it. */
static void testAxis(void) {
  for (int round = 0; round < 20; round++) {
    Bodies bodies = drawBodies();
    double frame[9];
    drawRotation(frame);
    /* Body 1 is turned as body 0 is, after a turn of its own about the z axis. */
    const double angle = 6 * draw();
    const double own[9] = {cos(angle), -sin(angle), 0, sin(angle), cos(angle), 0, 0, 0, 1};
    const double none[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int b = 0; b < BODIES; b++) {
      memcpy(bodies.before[b], none, sizeof none);
    }
    memcpy(bodies.after[0], frame, sizeof frame);
    for (int i = 0; i < 3; i++) {
      for (int j = 0; j < 3; j++) {
        bodies.after[1][3 * i + j] = 0;
        for (int k = 0; k < 3; k++) {
          bodies.after[1][3 * i + j] += frame[3 * i + k] * own[3 * k + j];
        }
      }
    }
    const double before = bodies.velocities[3 + 2] - bodies.velocities[2]; /* particle 1 is in body 1, 0 in body 0 */
    double inBody = 0;
    for (int k = 0; k < 3; k++) {
      inBody += (bodies.velocities[3 * BODIES + k] - bodies.velocities[k]) * (k + 1); /* along (1, 2, 3), body 0 */
    }
    turn(&bodies, round % 2 == 1);
    double along = 0;
    double stillInBody = 0;
    for (int k = 0; k < 3; k++) {
      along += (bodies.velocities[3 + k] - bodies.velocities[k]) * frame[3 * k + 2];
      const double line = frame[3 * k] + 2 * frame[3 * k + 1] + 3 * frame[3 * k + 2];
      stillInBody += (bodies.velocities[3 * BODIES + k] - bodies.velocities[k]) * line;
    }
    CHECK_NEAR(along, before, 1e-13);
    CHECK_NEAR(stillInBody, inBody, 1e-12);
  }
}

/* What is not turned keeps its bits; particles without mass count for nothing. */
static void testUnturned(void) {
  Bodies bodies = drawBodies();
  memcpy(bodies.after, bodies.before, sizeof bodies.after);
  double turns[BODIES][9];
  memcpy(turns, bodies.after, sizeof turns);
  CHECK(!ctFindTurns(BODIES, bodies.before, turns));
  drawRotation(bodies.after[2]);
  Bodies start = bodies;
  turn(&bodies, false);
  for (int i = 0; i < PARTICLES; i++) {
    const bool isSame = memcmp(bodies.velocities + 3 * i, start.velocities + 3 * i, 3 * sizeof(double)) == 0;
    CHECK(isSame == (bodies.bodyOf[i] != 2));
  }
  for (int i = 0; i < PARTICLES; i++) {
    start.masses[i] = 0;
  }
  turn(&start, true);
  CHECK(memcmp(bodies.velocities, start.velocities, sizeof start.velocities) == 0);
}

/* The direction of one set of accelerations becomes that of another; what is across both stays, and so does energy. */
static void testRotation(void) {
  for (int round = 0; round < 50; round++) {
    const Bodies from = drawBodies();
    const Bodies to = drawBodies();
    const Bodies start = drawBodies();
    Bodies bodies = start;
    ctRotateVelocities(PARTICLES, start.masses, from.velocities, to.velocities, bodies.velocities);
    CHECK_NEAR(kineticEnergy(&bodies) / kineticEnergy(&start), 1, 1e-13);
    double components[2] = {0};
    for (int i = 0; i < 3 * PARTICLES; i++) {
      components[0] += start.masses[i / 3] * start.velocities[i] * from.velocities[i];
      components[1] += start.masses[i / 3] * bodies.velocities[i] * to.velocities[i];
    }
    Bodies lengths[2] = {from, to};
    for (int k = 0; k < 2; k++) {
      memcpy(lengths[k].masses, start.masses, sizeof start.masses);
      components[k] /= sqrt(2 * kineticEnergy(&lengths[k]));
    }
    CHECK_NEAR(components[0], components[1], 1e-12);
    ctRotateVelocities(PARTICLES, start.masses, to.velocities, from.velocities, bodies.velocities);
    for (int i = 0; i < 3 * PARTICLES; i++) {
      CHECK_NEAR(bodies.velocities[i], start.velocities[i], 1e-12);
    }
    /* To the opposite, or to nothing, there is no least rotation. */
    double other[3 * PARTICLES];
    for (int k = 0; k < 2; k++) {
      for (int i = 0; i < 3 * PARTICLES; i++) {
        other[i] = k == 0 ? 0 : -2 * from.velocities[i];
      }
      bodies = start;
      ctRotateVelocities(PARTICLES, start.masses, from.velocities, other, bodies.velocities);
      CHECK(memcmp(bodies.velocities, start.velocities, sizeof start.velocities) == 0);
    }
  }
}

int main(void) {
  testRotation();
  testWhatStays();
  testOneTurnForAll();
  testAxis();
  testUnturned();
  return checkResult();
}
