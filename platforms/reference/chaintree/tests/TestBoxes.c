/* Rods and sheets, whose boxes are thin or flat, in any direction, shifted against each other: changed pairs against
 * all pairs, with boxes at all visits. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "check.h"

enum { MOST = 96 };

typedef struct Bodies {
  int count;
  double positions[3 * MOST];
} Bodies;

static double distance(const Bodies* bodies, int i, int j, const double shift[3]) {
  double squared = 0;
  for (int k = 0; k < 3; k++) {
    const double d = bodies->positions[3 * i + k] - bodies->positions[3 * j + k] - shift[k];
    squared += d * d;
  }
  return sqrt(squared);
}

/* How often each pair was reported, at what distances. */
typedef struct Found {
  int times[MOST][MOST];
  double before[MOST][MOST], after[MOST][MOST];
} Found;

static bool noteChanged(void* context, int particle1, int particle2, double before, double after) {
  Found* found = context;
  const int i = particle1 < particle2 ? particle1 : particle2, j = particle1 < particle2 ? particle2 : particle1;
  found->times[i][j]++;
  found->before[i][j] = before;
  found->after[i][j] = after;
  return true;
}

/* The second half is a body of its own: the changed pairs are the pairs across halves that are within the cutoff
 * before or after the shift. */
static void checkPairs(const Bodies* bodies, const double shift[3], double cutoff) {
  static const double still[3] = {0, 0, 0};
  static Found found;
  double radii[MOST];
  int links[MOST];
  const int parents[2] = {CT_NULL, CT_NULL};
  const uint8_t joints[2] = {ctFreeJoint, ctFreeJoint};
  const int half = bodies->count / 2;
  for (int i = 0; i < bodies->count; i++) {
    radii[i] = 0.01;
    links[i] = i >= half;
  }
  const ctDefinition definition = {.particleCount = bodies->count,
                                   .positions = bodies->positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = 2,
                                   .linkParents = parents,
                                   .linkJoints = joints};
  ctChainTree* tree = checkedCreate(&definition);
  ctChange change = {.link = 1};
  memcpy(change.translation, shift, sizeof change.translation);
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  memset(&found, 0, sizeof found);
  CHECK_SUCCESS(ctForEachChangedPair(tree, cutoff, noteChanged, &found, NULL));
  for (int i = 0; i < bodies->count; i++) {
    for (int j = i; j < bodies->count; j++) {
      const double before = distance(bodies, i, j, still), after = distance(bodies, i, j, shift);
      const bool changes = i < half && j >= half && (before <= cutoff || after <= cutoff);
      CHECK(found.times[i][j] == changes);
      CHECK(!changes || (fabs(found.before[i][j] - before) < 1e-12 && fabs(found.after[i][j] - after) < 1e-12));
    }
  }
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

int main(void) {
  const double directions[][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {1, 2, 3}, {-0.3, 0.7, 0.1}, {0.001, 1, 0}};
  const double across[][3] = {{0, 0, 0}, {0, 0.5, 0}, {0.3, 0.3, -0.3}, {1e-5, 0, 0}};
  const double displacements[][3] = {{0.31, -0.12, 0.23}, {-3.7, 1.1, 0.7}};
  setenv("CHAINTREE_TRIALS", "boxes", 1);
  for (int count = 2; count <= MOST; count += 1 + count / 8) {
    for (int d = 0; d < 6; d++) {
      for (int a = 0; a < 4; a++) {
        for (int rows = 1; rows <= 3; rows++) {
          Bodies bodies = {.count = count};
          for (int i = 0; i < count; i++) {
            for (int k = 0; k < 3; k++) {
              bodies.positions[3 * i + k] = i / rows * directions[d][k] + i % rows * across[a][k];
            }
          }
          /* Not at a distance that occurs. */
          checkPairs(&bodies, displacements[0], 2.718281828);
          checkPairs(&bodies, displacements[1], 2.718281828);
        }
      }
    }
  }
  return checkResult();
}
