#include "definition.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ctStatus invalid(char* errorText, size_t errorSize, const char* format, ...)
    __attribute__((format(printf, 3, 4)));

static ctStatus invalid(char* errorText, size_t errorSize, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(errorText, errorSize, format, arguments);
  va_end(arguments);
  return ctInvalidArgument;
}

/* The name of an array that is not there though it has elements; NULL if there is none. */
static const char* findMissing(const ctDefinition* d) {
  const struct {
    const char* name;
    const void* array;
    int count;
  } arrays[] = {
      {"positions", d->positions, d->particleCount},         {"radii", d->radii, d->particleCount},
      {"particleLinks", d->particleLinks, d->particleCount}, {"linkParents", d->linkParents, d->linkCount},
      {"linkJoints", d->linkJoints, d->linkCount},           {"exclusions", d->exclusions, d->exclusionCount}};
  for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
    if (arrays[i].count > 0 && arrays[i].array == NULL) {
      return arrays[i].name;
    }
  }
  return NULL;
}

/* True if all numbers are lengths. Without their signs, the bits of numbers ascend like their values, and those of
 * infinity and NaN are above. */
static bool hasLengths(size_t count, const double* x) {
  const double mostLength = CT_MOST_LENGTH;
  uint64_t most;
  memcpy(&most, &mostLength, sizeof most);
  uint64_t borrows = 0;
  for (size_t i = 0; i < count; i++) {
    uint64_t bits;
    memcpy(&bits, &x[i], sizeof bits);
    borrows |= most - (bits & 0x7fffffffffffffffu);
  }
  return borrows >> 63 == 0;
}

int ctFindBadPosition(int particleCount, const double* positions) {
  if (hasLengths(3 * (size_t)particleCount, positions)) {
    return CT_NULL;
  }
  int i = 0;
  while (areLengths(positions + 3 * (size_t)i)) {
    i++;
  }
  return i;
}

static ctStatus checkParticles(const ctDefinition* d, char* text, size_t size) {
  for (int i = 0; i < d->particleCount; i++) {
    if (!(d->radii[i] >= 0) || !isLength(d->radii[i])) {
      return invalid(text, size, "particle %d has radius %g; a radius must be from 0 to 1e15 nm", i, d->radii[i]);
    }
    if (!isIndex(d->particleLinks[i], d->linkCount)) {
      return invalid(text, size, "particle %d is in link %d; there are %d links", i, d->particleLinks[i], d->linkCount);
    }
    if (d->hydrogenBondRoles != NULL && d->hydrogenBondRoles[i] > ctDonorAndAcceptor) {
      return invalid(text, size, "particle %d has the unknown hydrogen bond role %d", i, d->hydrogenBondRoles[i]);
    }
  }
  const int bad = ctFindBadPosition(d->particleCount, d->positions);
  return bad == CT_NULL ? ctSuccess : invalid(text, size, "the position of particle %d " CT_NO_LENGTH, bad);
}

static ctStatus checkTorsion(const ctDefinition* d, int link, char* text, size_t size) {
  if (d->linkTorsions == NULL) {
    return invalid(text, size, "link %d has a torsion joint but no torsion is given", link);
  }
  const int* p = d->linkTorsions[link];
  for (int k = 0; k < 4; k++) {
    if (!isIndex(p[k], d->particleCount)) {
      return invalid(text, size, "the torsion of link %d names particle %d; there are %d particles", link, p[k],
                     d->particleCount);
    }
  }
  const int parent = d->linkParents[link];
  const int second = d->particleLinks[p[1]];
  const int third = d->particleLinks[p[2]];
  if (!((second == parent && third == link) || (second == link && third == parent))) {
    return invalid(text, size, "the torsion of link %d is about particles %d and %d, not between it and its parent %d",
                   link, p[1], p[2], parent);
  }
  return ctSuccess;
}

static ctStatus checkBall(const ctDefinition* d, int link, char* text, size_t size) {
  if (d->linkTorsions == NULL) {
    return invalid(text, size, "link %d has a ball joint but no particle is given about which it turns", link);
  }
  const int pivot = d->linkTorsions[link][1];
  if (!isIndex(pivot, d->particleCount)) {
    return invalid(text, size, "the ball joint of link %d names particle %d; there are %d particles", link, pivot,
                   d->particleCount);
  }
  if (d->particleLinks[pivot] != link && d->particleLinks[pivot] != d->linkParents[link]) {
    return invalid(text, size, "link %d turns about particle %d, which is neither in it nor in its parent %d", link,
                   pivot, d->linkParents[link]);
  }
  return ctSuccess;
}

static ctStatus checkLinks(const ctDefinition* d, char* text, size_t size) {
  for (int i = 0; i < d->linkCount; i++) {
    const int parent = d->linkParents[i];
    if (parent != CT_NULL && (!isIndex(parent, d->linkCount) || parent == i)) {
      return invalid(text, size, "link %d has the parent %d; there are %d links", i, parent, d->linkCount);
    }
    switch (d->linkJoints[i]) {
      case ctFixedJoint:
        if (parent != CT_NULL) {
          return invalid(text, size, "link %d has a parent and a fixed joint", i);
        }
        break;
      case ctFreeJoint:
        break;
      case ctTorsionJoint:
      case ctBallJoint: {
        const bool isBall = d->linkJoints[i] == ctBallJoint;
        if (parent == CT_NULL) {
          return invalid(text, size, "link %d has a %s joint and no parent", i, isBall ? "ball" : "torsion");
        }
        const ctStatus status = isBall ? checkBall(d, i, text, size) : checkTorsion(d, i, text, size);
        if (status != ctSuccess) {
          return status;
        }
        break;
      }
      default:
        return invalid(text, size, "link %d has the unknown joint %d", i, d->linkJoints[i]);
    }
  }
  return ctSuccess;
}

/* Checks that the parents of every link lead to a root, and that every link has a particle. */
static ctStatus checkForest(const ctDefinition* d, char* text, size_t size) {
  enum { UNSEEN, ON_PATH, DONE };
  uint8_t* mark = calloc((size_t)d->linkCount + 1, 1);
  if (mark == NULL) {
    return ctOutOfMemory;
  }
  ctStatus status = ctSuccess;
  for (int i = 0; i < d->linkCount && status == ctSuccess; i++) {
    int link = i;
    while (link != CT_NULL && mark[link] == UNSEEN) {
      mark[link] = ON_PATH;
      link = d->linkParents[link];
    }
    if (link != CT_NULL && mark[link] == ON_PATH) {
      status = invalid(text, size, "link %d is its own ancestor", link);
    }
    for (link = i; link != CT_NULL && mark[link] == ON_PATH; link = d->linkParents[link]) {
      mark[link] = DONE;
    }
  }
  for (int i = 0; i < d->particleCount; i++) {
    mark[d->particleLinks[i]] = UNSEEN;
  }
  for (int i = 0; i < d->linkCount && status == ctSuccess; i++) {
    if (mark[i] != UNSEEN) {
      status = invalid(text, size, "link %d has no particle", i);
    }
  }
  free(mark);
  return status;
}

ctStatus ctDefinitionCheck(const ctDefinition* d, char* text, size_t size) {
  /* Slots and tree nodes are counted in int. */
  if (d->particleCount < 0 || d->linkCount < 0 || d->exclusionCount < 0 || d->particleCount > CT_MOST_COUNT ||
      d->linkCount > CT_MOST_COUNT || d->exclusionCount > CT_MOST_COUNT) {
    return invalid(text, size, "the scene has %d particles, %d links and %d exclusions; counts must be from 0 to %d",
                   d->particleCount, d->linkCount, d->exclusionCount, CT_MOST_COUNT);
  }
  const char* missing = findMissing(d);
  if (missing != NULL) {
    return invalid(text, size, "%s is NULL", missing);
  }
  if (!(d->overlapTolerance >= 0) || !isLength(d->overlapTolerance)) {
    return invalid(text, size, "the overlap tolerance is %g; it must be from 0 to 1e15 nm", d->overlapTolerance);
  }
  if (!(d->hydrogenBondAllowance >= 0) || !isLength(d->hydrogenBondAllowance)) {
    return invalid(text, size, "the hydrogen bond allowance is %g; it must be from 0 to 1e15 nm",
                   d->hydrogenBondAllowance);
  }
  ctStatus status = checkParticles(d, text, size);
  if (status == ctSuccess) {
    status = checkLinks(d, text, size);
  }
  if (status == ctSuccess) {
    status = checkForest(d, text, size);
  }
  for (int i = 0; i < d->exclusionCount && status == ctSuccess; i++) {
    const int* pair = d->exclusions[i];
    if (!isIndex(pair[0], d->particleCount) || !isIndex(pair[1], d->particleCount) || pair[0] == pair[1]) {
      status = invalid(text, size, "exclusion %d is of particles %d and %d; there are %d particles", i, pair[0],
                       pair[1], d->particleCount);
    }
  }
  return status;
}
