/* The state of the sequence, and the transforms that follow from it. */
#include "sequence.h"

#include <float.h>
#include <string.h>

static void findOrigin(Sequence* s) {
  double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX};
  double high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
  for (int i = 0; i < s->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      const double x = s->reference[3 * (size_t)i + (size_t)k];
      low[k] = x < low[k] ? x : low[k];
      high[k] = x > high[k] ? x : high[k];
    }
  }
  for (int k = 0; k < 3; k++) {
    s->worldOrigin[k] = s->particleCount > 0 ? 0.5 * low[k] + 0.5 * high[k] : 0;
  }
}

static const JointState REFERENCE_JOINT = {0, 1, 0, {{1, 0, 0, 0}, {0, 0, 0}}};

/* Where the link's origin is in its parent's frame in the reference positions. */
static void referenceOffset(const Sequence* s, int link, double offset[3]) {
  subtract(s->origin[link], s->origin[s->parent[link]], offset);
}

void ctSequenceSetReference(Sequence* s, const double* positions) {
  if (s->particleCount > 0) { /* else positions may be NULL */
    memcpy(s->reference, positions, 3 * (size_t)s->particleCount * sizeof(double));
  }
  findOrigin(s);
  for (int link = 1; link < s->linkCount; link++) {
    const double* origin = s->reference + 3 * (size_t)s->originParticle[link];
    subtract(origin, s->worldOrigin, s->origin[link]);
    JointState joint = REFERENCE_JOINT;
    if (s->joint[link] == ctTorsionJoint) {
      double* axis = s->axis[link];
      subtract(origin, s->reference + 3 * (size_t)s->axisParticle[link], axis);
      const double length = sqrt(dot(axis, axis));
      for (int k = 0; k < 3; k++) {
        axis[k] = length > 0 ? axis[k] / length : 0;
      }
    } else {
      referenceOffset(s, link, joint.placement.position);
    }
    s->angle[link] = joint.angle;
    s->cosine[link] = joint.cosine;
    s->sine[link] = joint.sine;
    if (s->placementOf[link] != CT_NULL) {
      s->placement[s->placementOf[link]] = joint.placement;
    }
  }
  memset(s->displaced, 0, (size_t)s->linkCount * sizeof(int));
}

ctTransform ctSequenceOpening(const Sequence* s, int link) {
  ctTransform opening;
  if (s->joint[link] == ctTorsionJoint) {
    rotationAbout(s->axis[link], s->cosine[link], s->sine[link], opening.rotation);
    referenceOffset(s, link, opening.translation);
  } else {
    const Placement* placement = &s->placement[s->placementOf[link]];
    rotationFromQuaternion(placement->quaternion, opening.rotation);
    memcpy(opening.translation, placement->position, sizeof opening.translation);
  }
  return opening;
}

ctTransform ctSequenceStep(const Sequence* s, int link) {
  const ctTransform opening = ctSequenceOpening(s, link + 1);
  if (s->parent[link + 1] == link) {
    return opening;
  }
  return transformCompose(&s->closure[s->pathOf[link]], &opening);
}

JointState ctSequenceGetJoint(const Sequence* s, int link) {
  JointState joint = REFERENCE_JOINT;
  joint.angle = s->angle[link];
  joint.cosine = s->cosine[link];
  joint.sine = s->sine[link];
  if (s->placementOf[link] != CT_NULL) {
    joint.placement = s->placement[s->placementOf[link]];
  }
  return joint;
}

JointState ctJointAt(double angle) {
  JointState joint = REFERENCE_JOINT;
  joint.angle = angle;
  joint.cosine = cos(angle);
  joint.sine = sin(angle);
  return joint;
}

JointState ctJointTurned(const JointState* joint, double angle) {
  const double twoPi = 6.283185307179586476925286766559;
  return ctJointAt(remainder(joint->angle + remainder(angle, twoPi), twoPi));
}

JointState ctJointMoved(const JointState* joint, const double rotation[3], const double pivot[3],
                        const double shift[3]) {
  JointState moved = *joint;
  double turn[4];
  ctTransform motion;
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, motion.rotation);
  double arm[3];
  subtract(joint->placement.position, pivot, arm);
  rotate(motion.rotation, arm, arm);
  for (int k = 0; k < 3; k++) {
    moved.placement.position[k] = pivot[k] + arm[k] + shift[k];
  }
  quaternionMultiply(turn, joint->placement.quaternion, moved.placement.quaternion);
  return moved;
}

static bool isDisplaced(const Sequence* s, int link) {
  if (s->joint[link] == ctTorsionJoint) {
    return s->angle[link] != 0;
  }
  double offset[3];
  referenceOffset(s, link, offset);
  const Placement* placement = &s->placement[s->placementOf[link]];
  const double* q = placement->quaternion;
  const double* position = placement->position;
  return q[0] != 1 || q[1] != 0 || q[2] != 0 || q[3] != 0 || position[0] != offset[0] || position[1] != offset[1] ||
         position[2] != offset[2];
}

void ctSequenceSetJoint(Sequence* s, int link, const JointState* joint) {
  s->displaced[s->branch[link]] -= isDisplaced(s, link);
  s->angle[link] = joint->angle;
  s->cosine[link] = joint->cosine;
  s->sine[link] = joint->sine;
  if (s->placementOf[link] != CT_NULL) {
    s->placement[s->placementOf[link]] = joint->placement;
  }
  s->displaced[s->branch[link]] += isDisplaced(s, link);
}
