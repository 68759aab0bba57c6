#include "loopmember.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

bool makeLoopMember(const LoopShape* s, LoopMember* m) {
  const size_t joints = (size_t)s->jointCount, particles = (size_t)s->particleCount + 1;
  m->turns = malloc(joints * sizeof *m->turns);
  m->places = malloc(particles * sizeof *m->places);
  m->middles = malloc(joints * sizeof *m->middles);
  m->isPlaced = malloc(joints * sizeof *m->isPlaced);
  return m->turns != NULL && m->places != NULL && m->middles != NULL && m->isPlaced != NULL;
}

void freeLoopMember(LoopMember* m) {
  free(m->turns);
  free(m->places);
  free(m->middles);
  free(m->isPlaced);
}

void resetLoopMember(const LoopShape* s, LoopMember* m) {
  const Turning none = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
  memset(m->turns, 0, (size_t)s->jointCount * sizeof *m->turns);
  memset(m->isPlaced, 0, (size_t)s->jointCount * sizeof *m->isPlaced);
  m->head = m->tail = none;
  m->guide = m->weight = 1;
}

void copyPiece(const LoopShape* s, const LoopMember* from, LoopMember* to, int piece) {
  const int first = s->firsts[piece];
  const size_t count = (size_t)(s->firsts[piece + 1] - first);
  memcpy(to->places[first], from->places[first], count * sizeof *to->places);
  memcpy(to->middles[piece], from->middles[piece], sizeof *to->middles);
  to->isPlaced[piece] = from->isPlaced[piece];
  if (piece >= s->pathCount) {
    to->turns[piece] = from->turns[piece];
  }
}

void copyLoopMember(const LoopShape* s, const LoopMember* from, LoopMember* to) {
  for (int p = 1; p < s->jointCount; p++) {
    to->isPlaced[p] = false;
    if (from->isPlaced[p]) {
      copyPiece(s, from, to, p);
    }
  }
  memcpy(to->turns, from->turns, (size_t)s->jointCount * sizeof *to->turns);
  to->head = from->head;
  to->tail = from->tail;
  to->guide = from->guide;
  to->weight = from->weight;
}

/* True if two spheres overlap by more than a tolerance. */
static inline bool overlap(const double x1[3], double radius1, const double x2[3], double radius2, double tolerance) {
  double apart[3];
  subtract(x1, x2, apart);
  const double reach = radius1 + radius2 - tolerance;
  return reach > 0 && dot(apart, apart) < reach * reach;
}

/* True if a particle of the loop clashes with a fixed one. */
static bool meetsFixed(const LoopShape* s, const LoopMember* m, int i) {
  const int* near;
  const int count = spheresNear(&s->grid, m->places[i], &near);
  const double radius = s->spheres[i].radius;
  for (int k = 0; k < count; k++) {
    const int j = near[k];
    const Sphere* other = &s->fixedSpheres[j];
    if (overlap(m->places[i], radius, other->x, other->radius, s->tolerance) &&
        overlap(m->places[i], radius, other->x, other->radius, toleranceOf(s, s->roles[i], s->fixedRoles[j])) &&
        !arePartners(&s->fixedPartners, i, j)) {
      return true;
    }
  }
  return false;
}

/* True if two particles of the loop clash. */
static bool meet(const LoopShape* s, const LoopMember* m, int i, int j) {
  const double radius = s->spheres[i].radius, other = s->spheres[j].radius;
  return other > 0 && overlap(m->places[i], radius, m->places[j], other, s->tolerance) &&
         overlap(m->places[i], radius, m->places[j], other, toleranceOf(s, s->roles[i], s->roles[j])) &&
         !arePartners(&s->partners, i, j);
}

static bool meetsPiece(const LoopShape* s, const LoopMember* m, int piece, int other) {
  if (!overlap(m->middles[piece], s->bounds[piece].radius, m->middles[other], s->bounds[other].radius, s->tolerance)) {
    return false;
  }
  for (int i = s->firsts[piece]; i < s->firsts[piece + 1]; i++) {
    for (int j = s->firsts[other]; j < s->firsts[other + 1]; j++) {
      if (s->spheres[i].radius > 0 && meet(s, m, i, j)) {
        return true;
      }
    }
  }
  return false;
}

bool placePiece(const LoopShape* s, LoopMember* m, int piece, const Turning* motion) {
  turnPoint(motion, s->bounds[piece].x, m->middles[piece]);
  for (int i = s->firsts[piece]; i < s->firsts[piece + 1]; i++) {
    turnPoint(motion, s->spheres[i].x, m->places[i]);
    if (s->spheres[i].radius > 0 && meetsFixed(s, m, i)) {
      return false;
    }
  }
  for (int other = 1; other < s->jointCount; other++) {
    if (m->isPlaced[other] && meetsPiece(s, m, piece, other)) {
      return false;
    }
  }
  m->isPlaced[piece] = true;
  return true;
}
