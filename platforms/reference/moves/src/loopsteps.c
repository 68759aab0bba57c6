#include "loopsteps.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "turning.h"

/* The two half turns that stand for the joints before and behind the window; see closing.c. */
#define MOST_CLOSING (CT_WINDOW_MOST - 2)

/* nm. Axes of neighbors meet if the point of the first is this near to the second. */
#define MEETS 1e-6

#define HALF_TURN 3.141592653589793238462643383280

#define SAMPLES 200000

/* Of the largest value: loops that are rarer are grown all the same. */
#define LEAST_VALUE 1e-6

/* The share in a bin of what its distance alone would give. */
#define BLUR 0.05

/* ---- Closing ---- */

/* True if a set of the path can be a pair of pivots. */
static bool isPair(const LoopShape* s, const JointSet* set) {
  if (set->body != -1 || set->count != 2) {
    return false;
  }
  double arm[3], across[3];
  subtract(s->points[set->joints[0]], s->points[set->joints[1]], arm);
  cross(arm, s->axes[set->joints[1]], across);
  return sqrt(dot(across, across)) < MEETS;
}

/* Chooses three pairs: as near to each other as there are, and then nearest to the middle, where the joints at both
 * ends are grown before them. */
static bool choosePivots(const LoopShape* s, LoopSteps* steps) {
  int* pairs = malloc(((size_t)s->setCount + 1) * sizeof *pairs);
  int count = 0;
  if (pairs == NULL) {
    return false;
  }
  for (int j = 0; j + 1 < s->pathCount; j++) {
    const int set = s->setOf[j];
    if (set != -1 && s->sets[set].joints[0] == j && isPair(s, &s->sets[set])) {
      pairs[count++] = j;
    }
  }
  int shortest = MOST_CLOSING + 1, nearest = 0;
  for (int i = 0; i + 2 < count; i++) {
    const int length = pairs[i + 2] + 2 - pairs[i];
    const int offset = abs(pairs[i] + pairs[i + 2] + 1 - (s->pathCount - 1));
    if (length < shortest || (length == shortest && offset < nearest)) {
      shortest = length;
      nearest = offset;
      steps->closingFirst = pairs[i];
      steps->closingLast = pairs[i + 2] + 1;
      for (int k = 0; k < CT_PIVOTS; k++) {
        steps->pivots[k] = pairs[i + k / 2] + k % 2;
      }
    }
  }
  free(pairs);
  return shortest <= MOST_CLOSING;
}

/* ---- Meetings ---- */

static int binOf(double value, double least, double most, int count) {
  const int bin = (int)((value - least) / (most - least) * count);
  return bin < 0 ? 0 : bin < count ? bin : count - 1;
}

int binOfMeeting(const Meetings* meetings, const double x1[3], const double u1[3], const double x2[3],
                 const double u2[3]) {
  double line[3], side1[3], side2[3], above[3];
  subtract(x2, x1, line);
  const double distance = sqrt(dot(line, line));
  scale(line, 1 / fmax(distance, 1e-9));
  cross(u1, line, side1);
  cross(line, u2, side2);
  cross(side1, side2, above);
  const double dihedral = atan2(dot(above, line), dot(side1, side2));
  const int bin = binOf(distance, 0, meetings->width * DISTANCE_BINS, DISTANCE_BINS);
  const int cosine1 = binOf(dot(u1, line), -1, 1, COSINE_BINS), cosine2 = binOf(dot(u2, line), -1, 1, COSINE_BINS);
  return ((bin * COSINE_BINS + cosine1) * COSINE_BINS + cosine2) * DIHEDRAL_BINS +
         binOf(dihedral, -HALF_TURN, HALF_TURN, DIHEDRAL_BINS);
}

/* A generator for tables that need no other quality: splitmix64 of Steele, Lea, Flood (2014). */
static double nextUniform(uint64_t* state) {
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* Draws turns of the joints of the path; those in no set keep their angles. */
static void drawTurns(const LoopShape* s, uint64_t* state, double* turns) {
  for (int j = 0; j < s->pathCount; j++) {
    const JointSet* set = s->setOf[j] == -1 ? NULL : &s->sets[s->setOf[j]];
    if (set == NULL) {
      turns[j] = 0;
    } else if (set->joints[0] == j) {
      double uniforms[CT_UNIFORMS_MOST], drawn[CT_DENSITY_MOST];
      for (int i = 0; i < set->uniformCount; i++) {
        uniforms[i] = nextUniform(state);
      }
      ctDrawAngles(set->density, uniforms, drawn);
      for (int i = 0; i < set->count; i++) {
        turns[j + i] = drawn[i] - s->angles[j + i];
      }
    }
  }
}

/* The length of the path between the points of two joints. */
static double lengthOf(const LoopShape* s, int first, int last) {
  double length = 0;
  for (int j = first; j < last; j++) {
    double side[3];
    subtract(s->points[j + 1], s->points[j], side);
    length += sqrt(dot(side, side));
  }
  return length;
}

/* Counts meetings of the ends of what remains after each step, in free chains. */
static void countMeetings(const LoopShape* s, LoopSteps* steps, double* turns, Turning* motions) {
  uint64_t state = 1;
  for (int sample = 0; sample < SAMPLES; sample++) {
    drawTurns(s, &state, turns);
    Turning motion = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    for (int j = 0; j < s->pathCount; j++) {
      motions[j] = motion;
      const Turning turn = turningAbout(s->points[j], s->axes[j], turns[j]);
      turnFirst(&motion, &turn);
    }
    for (int i = 0; i < steps->count; i++) {
      const GrowthStep* step = &steps->steps[i];
      double x1[3], u1[3], x2[3], u2[3];
      turnPoint(&motions[step->headJoint], s->points[step->headJoint], x1);
      turnDirection(&motions[step->headJoint], s->axes[step->headJoint], u1);
      turnPoint(&motions[step->tailJoint], s->points[step->tailJoint], x2);
      turnDirection(&motions[step->tailJoint], s->axes[step->tailJoint], u2);
      step->meetings->values[binOfMeeting(step->meetings, x1, u1, x2, u2)]++;
    }
  }
}

/* Makes densities of counts. */
static void scaleMeetings(Meetings* meetings) {
  const int rest = MEETING_BINS / DISTANCE_BINS;
  float largest = 0;
  for (int i = 0; i < DISTANCE_BINS; i++) {
    float* values = meetings->values + i * rest;
    float sum = 0;
    for (int k = 0; k < rest; k++) {
      sum += values[k];
    }
    for (int k = 0; k < rest; k++) {
      values[k] = (values[k] + (float)BLUR * sum / (float)rest) / (((float)i + 0.5f) * ((float)i + 0.5f));
      largest = fmaxf(largest, values[k]);
    }
  }
  for (int i = 0; i < MEETING_BINS; i++) {
    meetings->values[i] = fmaxf(meetings->values[i] / largest, (float)LEAST_VALUE);
  }
}

/* ---- Steps ---- */

/* The step from joint `from` of the path towards joint `end`, which it does not reach: one set, and all joints before
 * and behind it that are in none, so that these have their places in the same draws. */
static GrowthStep stepFrom(const LoopShape* s, int from, int end) {
  const int way = from < end ? 1 : -1;
  GrowthStep step = {.isFromHead = way > 0, .set = -1};
  int joint = from;
  while (joint != end && (s->setOf[joint] == -1 || step.set == -1 || s->setOf[joint] == step.set)) {
    step.set = s->setOf[joint] == -1 ? step.set : s->setOf[joint];
    joint += way;
  }
  step.first = way > 0 ? from : joint + 1;
  step.last = way > 0 ? joint - 1 : from;
  return step;
}

/* Makes tables of meetings. False if there is no memory. */
static bool makeMeetings(const LoopShape* s, LoopSteps* steps) {
  double* turns = malloc((size_t)s->pathCount * sizeof *turns);
  Turning* motions = malloc((size_t)s->pathCount * sizeof *motions);
  bool hasMemory = turns != NULL && motions != NULL;
  for (int i = 0; i < steps->count; i++) {
    GrowthStep* step = &steps->steps[i];
    step->meetings = calloc(1, sizeof *step->meetings);
    hasMemory = hasMemory && step->meetings != NULL;
    if (hasMemory) {
      step->meetings->width = (lengthOf(s, step->headJoint, step->tailJoint) + 1e-9) / DISTANCE_BINS;
    }
  }
  if (hasMemory) {
    countMeetings(s, steps, turns, motions);
    for (int i = 0; i < steps->count; i++) {
      scaleMeetings(steps->steps[i].meetings);
    }
  }
  free(turns);
  free(motions);
  return hasMemory;
}

bool planLoopSteps(const LoopShape* s, LoopSteps* steps, const char** problem) {
  *steps = (LoopSteps){0};
  *problem = "there is no memory";
  steps->steps = malloc((size_t)s->pathCount * sizeof *steps->steps);
  if (steps->steps == NULL) {
    return false;
  }
  if (!choosePivots(s, steps)) {
    *problem = "no three residues whose phi and psi both turn lie near enough to each other to close it";
    return false;
  }
  int head = 0, tail = s->pathCount - 1;
  while (head < steps->closingFirst || tail > steps->closingLast) {
    const bool isFromHead = steps->closingFirst - head >= tail - steps->closingLast;
    GrowthStep* step = &steps->steps[steps->count++];
    *step = isFromHead ? stepFrom(s, head, steps->closingFirst) : stepFrom(s, tail, steps->closingLast);
    head = isFromHead ? step->last + 1 : head;
    tail = isFromHead ? tail : step->first - 1;
    step->headJoint = head;
    step->tailJoint = tail;
  }
  if (steps->count == 0) { /* nothing grows before the joints that close */
    steps->steps[steps->count++] = (GrowthStep){.isFromHead = true, .set = -1, .last = -1, .tailJoint = tail};
  }
  return makeMeetings(s, steps);
}

void freeLoopSteps(LoopSteps* steps) {
  for (int i = 0; i < steps->count; i++) {
    free(steps->steps[i].meetings);
  }
  free(steps->steps);
}
