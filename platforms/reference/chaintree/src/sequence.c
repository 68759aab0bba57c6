/* The state of the sequence, and the transforms that follow from it. */
#include "sequence.h"

#include <float.h>
#include <string.h>

/* Coordinates at a time, to fill registers: number i of them is along axis i % 3. */
enum { LANES = 12 };

static void findOrigin(Sequence* s) {
  const size_t count = 3 * (size_t)s->particleCount;
  double low[LANES];
  double high[LANES];
  for (int k = 0; k < LANES; k++) {
    low[k] = DBL_MAX;
    high[k] = -DBL_MAX;
  }
  for (size_t i = 0; i < count; i += LANES) {
    const int lanes = count - i < LANES ? (int)(count - i) : LANES;
    for (int k = 0; k < lanes; k++) {
      const double x = s->reference[i + (size_t)k];
      low[k] = x < low[k] ? x : low[k];
      high[k] = x > high[k] ? x : high[k];
    }
  }
  for (int k = 3; k < LANES; k++) {
    low[k % 3] = lesser(low[k % 3], low[k]);
    high[k % 3] = larger(high[k % 3], high[k]);
  }
  for (int k = 0; k < 3; k++) {
    s->worldOrigin[k] = count > 0 ? 0.5 * low[k] + 0.5 * high[k] : 0;
  }
}

static const JointState REFERENCE_JOINT = {0, {{1, 0, 0, 0}, {0, 0, 0}}, {0, 0, 0}};

/* ---- Wrapped molecules ---- */

/* A molecule that moves is wrapped if its root is farther from worldOrigin, in box vectors. More than a half, so that
 * one at a face of the box is not wrapped again and again. */
#define MOST_VECTORS_AWAY 0.6

void ctSequenceShift(const Sequence* s, int branch, double shift[3]) {
  shift[0] = shift[1] = shift[2] = 0;
  if (s->box.isPeriodic && branch != CT_NULL) {
    ctImageShift(&s->box, s->wrap[branch], shift);
  }
}

bool ctSequenceIsWrapped(const Sequence* s) {
  for (int branch = 0; branch < s->branchCount && s->box.isPeriodic; branch++) {
    const int* n = s->wrap[branch];
    if (n[0] != 0 || n[1] != 0 || n[2] != 0) {
      return true;
    }
  }
  return false;
}

void ctSequenceLinkShift(const Sequence* s, int link, double shift[3]) {
  ctSequenceShift(s, s->box.isPeriodic ? sequenceBranch(s, link) : CT_NULL, shift);
}

/* Wraps a root that is farther away, in box vectors. */
static void wrapBeyond(const Sequence* s, double mostAway, JointState* joint, double shift[3]) {
  double* position = joint->placement.position;
  double left[3] = {position[0], position[1], position[2]};
  bool isFar = false;
  shift[0] = shift[1] = shift[2] = 0;
  for (int k = 2; k >= 0; k--) {
    const double count = left[k] / s->box.vectors[k][k];
    isFar = isFar || fabs(count) > mostAway;
    for (int d = 0; d < k; d++) {
      left[d] -= count * s->box.vectors[k][d];
    }
  }
  if (isFar) {
    const Image image = ctNearestImage(&s->box, position);
    for (int d = 0; d < 3; d++) {
      shift[d] = image.shift[d];
      position[d] += shift[d];
      joint->wrap[d] += image.n[d];
    }
  }
}

void ctJointWrap(const Sequence* s, JointState* joint, double shift[3]) {
  wrapBeyond(s, MOST_VECTORS_AWAY, joint, shift);
}

/* The placement of a link in the reference positions, as it is wrapped. */
static void restPosition(const Sequence* s, int link, double position[3]) {
  sequenceOffset(s, link, position);
  if (isWrapped(s, link)) {
    double shift[3];
    ctSequenceLinkShift(s, link, shift);
    add(position, shift);
  }
}

/* ---- State ---- */

void ctSequenceResetTorsions(Sequence* s) {
  for (int link = 0; link < s->linkCount; link++) {
    s->angle[link] = REFERENCE_JOINT.angle;
    s->rodrigues[link] = 0;
  }
  for (int branch = 0; branch < s->branchCount; branch++) {
    s->displaced[branch] = 0;
  }
  s->displacedCount = 0;
}

static uint8_t axisPlacesOf(const Sequence* s, int link) {
  if (!s->isFlexible && !ctSequenceCanTurn(s, link, s->reference)) { /* in a flexible scene that may change */
    return axisIsNoLine;
  }
  const int from = particleSlot(s, s->joint[link].torsion[0]);
  const int to = particleSlot(s, s->joint[link].origin);
  const int leaf = coveringNode(s->slotBegin[link]);
  const bool areHere = from != CT_NULL && to != CT_NULL && coveringNode(from) == leaf && coveringNode(to) == leaf;
  return areHere ? (uint8_t)(TREE_WIDTH * memberIndex(from) + memberIndex(to)) : axisElsewhere;
}

/* Finds the origin of the world. In a flexible scene, each link takes its origin from its particle. */
static void setOrigins(Sequence* s) {
  findOrigin(s);
  double* origin = s->reference + 3 * (size_t)s->particleCount;
  for (int link = 0; link < s->linkCount && s->isFlexible; link++) {
    const double* from = link == 0 ? s->worldOrigin : s->reference + 3 * (size_t)s->joint[link].origin;
    memcpy(origin + 3 * (size_t)link, from, 3 * sizeof *origin);
  }
}

void ctSequenceSetReference(Sequence* s, const double* positions, Origins origins) {
  if (s->particleCount > 0) { /* else positions may be NULL */
    memcpy(s->reference, positions, 3 * (size_t)s->particleCount * sizeof(double));
  }
  if (origins == originsOfParticles) {
    setOrigins(s);
  }
  if (s->displacedCount > 0) {
    ctSequenceResetTorsions(s);
  }
  for (int link = 1; link < s->linkCount; link++) {
    if (s->dihedral != NULL) {
      s->dihedral[link] = NAN;
    }
    if (s->jointType[link] == ctTorsionJoint) {
      s->axisPlaces[link] = axisPlacesOf(s, link);
    }
    if (isPlaced(s, link)) {
      Placement* placement = placementOf(s, link);
      *placement = REFERENCE_JOINT.placement;
      if (isWrapped(s, link)) {
        JointState joint = REFERENCE_JOINT;
        double shift[3];
        sequenceOffset(s, link, joint.placement.position);
        wrapBeyond(s, 0.5, &joint, shift);
        memcpy(s->wrap[sequenceBranch(s, link)], joint.wrap, sizeof joint.wrap);
      }
      restPosition(s, link, placement->position);
    }
  }
}

bool ctSequenceCanTurn(const Sequence* s, int link, const double* reference) {
  double axis[3];
  sequenceAxis(s, link, reference, axis);
  return dot(axis, axis) > 0;
}

JointState ctSequenceGetJoint(const Sequence* s, int link) {
  JointState joint = REFERENCE_JOINT;
  joint.angle = s->angle[link];
  if (isPlaced(s, link)) {
    joint.placement = *placementOf(s, link);
  }
  if (isWrapped(s, link)) {
    memcpy(joint.wrap, s->wrap[sequenceBranch(s, link)], sizeof joint.wrap);
  }
  return joint;
}

double ctAngleTurned(double angle, double turn) {
  const double twoPi = 6.283185307179586476925286766559;
  const double pi = 0.5 * twoPi;
  double within = turn; /* one turn: for many the digits of pi in double are too few */
  if (fabs(turn) > twoPi) {
    within = fabs(turn) <= CT_EXACT_ANGLE ? withoutTurns(turn) : atan2(sin(turn), cos(turn));
  }
  const double sum = angle + within;
  /* Since the sum is below 3 pi, this is remainder(sum, twoPi), and quicker. */
  return sum - twoPi * ((sum > pi) - (sum < -pi));
}

JointState ctJointTurned(const JointState* joint, const double rotation[3]) {
  JointState turned = *joint;
  double turn[4];
  quaternionFromVector(rotation, turn);
  quaternionMultiply(turn, joint->placement.quaternion, turned.placement.quaternion);
  return turned;
}

/* The vector that a frame rotates to x. The rotation of a quaternion whose length is 1 up to rounding is orthogonal up
 * to that, and this error has a sign more often than the other: over many turns it would add up. */
static void rotateBackExactly(const Frame* frame, const double x[3], double rotated[3]) {
  const double wanted[3] = {x[0], x[1], x[2]};
  double rest[3];
  rotateBack(frame, wanted, rotated);
  rotate(frame, rotated, rest);
  subtract(wanted, rest, rest);
  rotateBack(frame, rest, rest);
  add(rotated, rest);
}

/* By how much the squared length of a quaternion exceeds 1. A quarter is subtracted from each square first, since sums
 * near 1 are rounded more finely below 1 than above. */
static double excessOf(const double q[4]) {
  return ((q[0] * q[0] - 0.25) + (q[1] * q[1] - 0.25)) + ((q[2] * q[2] - 0.25) + (q[3] * q[3] - 0.25));
}

/* Turns a placement's rotation by a unit quaternion, in the parent's frame. A division by the rounded length would
 * round more often down than up, and the sum over many turns would turn the link. */
static void turnPlacement(const double turn[4], Placement* placement) {
  const double* a = turn;
  const double b[4] = {placement->quaternion[0], placement->quaternion[1], placement->quaternion[2],
                       placement->quaternion[3]};
  double* c = placement->quaternion;
  c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
  const double half = 0.5 * excessOf(c);
  for (int k = 0; k < 4; k++) {
    c[k] -= half * c[k];
  }
}

/* Puts the point `local` of a link that has been turned at a point of its parent's frame. */
static void putPoint(Placement* turned, const double local[3], const double point[3]) {
  Frame frame;
  double arm[3];
  rotationFromQuaternion(turned->quaternion, &frame);
  rotate(&frame, local, arm);
  subtract(point, arm, turned->position);
}

/* Turns in the parent's frame, where the axis stays: its direction in the link's frame would take up the roundings of
 * the link's rotation, turn by turn. */
JointState ctTorsionTurned(const Sequence* s, int link, double angle) {
  JointState turned = ctSequenceGetJoint(s, link);
  const Frame before = sequenceLocalFrame(s, link);
  double from[3];
  double to[3];
  double end[3];
  double axis[3];
  sequenceLocal(s, s->parent[link], s->joint[link].torsion[0], from);
  sequenceLocal(s, link, s->joint[link].origin, to);
  transformPoint(&before, to, end);
  subtract(end, from, axis);
  const Angle half = angleOfAny(0.5 * angle);
  const double factor = half.sine / sqrt(dot(axis, axis));
  const double turn[4] = {half.cosine, factor * axis[0], factor * axis[1], factor * axis[2]};
  turnPlacement(turn, &turned.placement);
  putPoint(&turned.placement, to, end);
  return turned;
}

JointState ctBallTurned(const Sequence* s, int link, const double rotation[3]) {
  JointState turned = ctSequenceGetJoint(s, link);
  const Frame before = sequenceLocalFrame(s, link);
  const int particle = s->joint[link].origin;
  const int holder = particleLink(s, particle);
  double local[3];
  double pivot[3];
  if (holder == link) {
    sequenceLocal(s, link, particle, local);
    transformPoint(&before, local, pivot);
  } else {
    sequenceLocal(s, holder, particle, pivot);
    subtract(pivot, turned.placement.position, local);
    rotateBackExactly(&before, local, local);
  }
  double turn[4];
  quaternionFromVector(rotation, turn);
  turnPlacement(turn, &turned.placement);
  putPoint(&turned.placement, local, pivot);
  return turned;
}

JointState ctJointMoved(const JointState* joint, const double rotation[3], const double pivot[3],
                        const double shift[3]) {
  JointState moved = ctJointTurned(joint, rotation);
  double turn[4];
  Frame motion;
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, &motion);
  double arm[3];
  subtract(joint->placement.position, pivot, arm);
  rotate(&motion, arm, arm);
  for (int k = 0; k < 3; k++) {
    moved.placement.position[k] = pivot[k] + arm[k] + shift[k];
  }
  return moved;
}

static bool isDisplaced(const Sequence* s, int link) {
  if (hasAngle(s, link)) {
    return s->angle[link] != 0;
  }
  double offset[3];
  restPosition(s, link, offset);
  const Placement* placement = placementOf(s, link);
  const double* q = placement->quaternion;
  const double* position = placement->position;
  return q[0] != 1 || q[1] != 0 || q[2] != 0 || q[3] != 0 || position[0] != offset[0] || position[1] != offset[1] ||
         position[2] != offset[2];
}

static double rodriguesAt(const Sequence* s, int link, double angle) {
  if (angle == 0) { /* also where there is no axis */
    return 0;
  }
  double axis[3];
  sequenceAxis(s, link, s->reference, axis);
  return rodriguesFactor(axis, angle);
}

void ctSequenceSetJoint(Sequence* s, int link, const JointState* joint) {
  const bool before = isDisplaced(s, link);
  s->angle[link] = joint->angle;
  s->rodrigues[link] = rodriguesAt(s, link, joint->angle);
  if (isPlaced(s, link)) {
    *placementOf(s, link) = joint->placement;
  }
  if (isWrapped(s, link)) {
    memcpy(s->wrap[sequenceBranch(s, link)], joint->wrap, sizeof joint->wrap);
  }
  const bool after = isDisplaced(s, link);
  if (after != before) {
    s->displaced[sequenceBranch(s, link)] += after ? 1 : -1;
    s->displacedCount += after ? 1 : -1;
  }
}
