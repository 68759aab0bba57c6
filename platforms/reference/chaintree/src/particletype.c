/* Types of particles: radius and role, on which the limit of a pair depends, kept once for all particles that share
 * them. */
#include <string.h>

#include "sequence.h"

static unsigned roleOf(const ctDefinition* d, int particle) {
  return d->hydrogenBondRoles == NULL ? ctNoHydrogenBond : d->hydrogenBondRoles[particle];
}

static bool areAlike(const ctDefinition* d, int particleA, int particleB) {
  return d->radii[particleA] == d->radii[particleB] && roleOf(d, particleA) == roleOf(d, particleB);
}

/* The upper bits, which depend on all others, of a product with an odd number (Knuth). */
static uint32_t hashOf(const ctDefinition* d, int particle) {
  uint64_t bits;
  memcpy(&bits, &d->radii[particle], sizeof bits);
  return (uint32_t)((bits ^ roleOf(d, particle)) * 0x9e3779b97f4a7c15u >> 32);
}

/* Numbers the types in the order of their first slots. Slots without a particle get any type. */
static void numberTypes(Sequence* s, const ctDefinition* d, int* table, uint32_t mask) {
  for (int slot = 0; slot < s->slotCount; slot++) {
    const int particle = s->slotParticle[slot];
    if (particle == CT_NULL) {
      continue;
    }
    uint32_t i = hashOf(d, particle) & mask;
    while (table[i] > 0 && !areAlike(d, s->slotParticle[table[i] - 1], particle)) {
      i = (i + 1) & mask;
    }
    if (table[i] == 0) {
      table[i] = slot + 1; /* the first of its type */
      s->slotType[slot] = s->typeCount++;
    } else {
      s->slotType[slot] = s->slotType[table[i] - 1];
    }
  }
}

bool ctTypesBuild(Sequence* s, Arena* arena, const ctDefinition* d) {
  uint32_t size = 1;
  while (size < 2 * (uint32_t)s->slotCount) {
    size *= 2;
  }
  Arena scratch = {0};
  int* table = ctArenaAllocate(&scratch, size, sizeof(int));
  if (!scratch.failed) {
    numberTypes(s, d, table, size - 1);
    s->types = ctArenaAllocate(arena, (size_t)s->typeCount + 1, sizeof(ParticleType));
  }
  const bool built = !scratch.failed && !arena->failed;
  ctArenaFree(&scratch);
  for (int slot = 0; slot < s->slotCount && built; slot++) {
    const int particle = s->slotParticle[slot];
    if (particle != CT_NULL) {
      s->types[s->slotType[slot]] = (ParticleType){d->radii[particle], roleOf(d, particle)};
    }
  }
  return built;
}

double ctLargestRadius(const Sequence* s) {
  double radius = 0;
  for (int i = 0; i < s->typeCount; i++) {
    radius = larger(radius, s->types[i].radius);
  }
  return radius;
}
