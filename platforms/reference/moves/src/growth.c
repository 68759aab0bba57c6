#include "ctgrowth.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "closing.h"
#include "loopmember.h"

/* nm. A loop is closed if its end is this near to where it has to be. */
#define CLOSED 1e-10

/* Members are drawn again if their effective number is below this part of them. */
#define LEAST_EFFECTIVE 0.5

/* Ends that meet less often, relative to the most, are grown with a chance in proportion. */
#define ENOUGH 1e-3

/* Draws that are enough for a step, in addition to one that ends them. */
#define WANTED 4
#define WANTED_SIDES 3

/* How many times as many there are of the last step. */
#define LAST_FACTOR 4

struct ctGrowth {
  LoopShape shape;
  LoopSteps steps;
};

/* A run: the loop, the random numbers, and memory for draws among which one is chosen. */
typedef struct Run {
  const LoopShape* shape;
  const LoopSteps* steps;
  const ctGrowthRun* how;
  LoopMember chosen;
  LoopMember chosenSide;
  LoopMember joined; /* the closing joints and their pieces */
  Turning* motions;  /* of each piece */
} Run;

ctGrowth* ctCreateGrowth(const ctGrowthDefinition* definition, const char** problem) {
  const char* unheard;
  problem = problem == NULL ? &unheard : problem;
  *problem = "there is no memory";
  ctGrowth* growth = calloc(1, sizeof *growth);
  if (growth != NULL && (!makeLoopShape(definition, &growth->shape, problem) ||
                         !planLoopSteps(&growth->shape, &growth->steps, problem))) {
    ctDestroyGrowth(growth);
    return NULL;
  }
  return growth;
}

void ctDestroyGrowth(ctGrowth* growth) {
  if (growth != NULL) {
    freeLoopShape(&growth->shape);
    freeLoopSteps(&growth->steps);
    free(growth);
  }
}

static double draw(const Run* run) {
  return run->how->uniform(run->how->context);
}

/* An angle in [-pi, pi] of one that is less than two turns from it. */
static double wrap(double angle) {
  return remainder(angle, 6.283185307179586476925286766559);
}

/* ---- Joints ---- */

static void drawSet(const Run* run, const JointSet* set, double* turns) {
  double uniforms[CT_UNIFORMS_MOST], angles[CT_DENSITY_MOST];
  for (int i = 0; i < set->uniformCount; i++) {
    uniforms[i] = draw(run);
  }
  ctDrawAngles(set->density, uniforms, angles);
  for (int i = 0; i < set->count; i++) {
    turns[set->joints[i]] = angles[i] - run->shape->angles[set->joints[i]];
  }
}

static double densityOf(const LoopShape* s, const JointSet* set, const double* turns) {
  double angles[CT_DENSITY_MOST];
  for (int i = 0; i < set->count; i++) {
    angles[i] = wrap(s->angles[set->joints[i]] + turns[set->joints[i]]);
  }
  return ctGetDensity(set->density, angles);
}

static Turning turnOf(const LoopShape* s, int joint, double angle) {
  return turningAbout(s->points[joint], s->axes[joint], angle);
}

/* ---- Tries ---- */

/* Independent draws, each with a value, until `wanted` of them have a value above 0 or `most` are made. The last of the
 * wanted ones ends them and does not count: then the sum of the others over the number of others has the mean of a
 * single draw as its mean (Haldane, Biometrika 33, 222 (1945)). One of those that count is kept, by its value. */
typedef struct Tries {
  int most;
  int wanted;
  int made;
  int found;
  double sum;
} Tries;

static bool hasNext(Tries* tries) {
  if (tries->made == tries->most || tries->found == tries->wanted) {
    return false;
  }
  tries->made++;
  return true;
}

/* Counts a draw of a value above 0. True if it replaces the one that is kept. */
static bool keepsTry(const Run* run, Tries* tries, double value) {
  tries->found++;
  if (tries->found == tries->wanted) {
    return false;
  }
  tries->sum += value;
  return draw(run) * tries->sum < value;
}

static double meanOfTries(const Tries* tries) {
  return tries->sum / (tries->found == tries->wanted ? tries->made - 1 : tries->made);
}

/* ---- Side chains ---- */

/* Places all pieces that hang on one of the path, by new draws. False, with some of them placed, if one clashes. */
static bool placeSide(Run* run, LoopMember* member, int body) {
  const LoopShape* s = run->shape;
  for (int i = 0; i < s->setCount; i++) {
    if (s->sets[i].body == body) {
      drawSet(run, &s->sets[i], member->turns);
    }
  }
  for (int p = s->pathCount; p < s->jointCount; p++) {
    if (s->bodies[p] == body) {
      const Turning turn = turnOf(s, p, member->turns[p]);
      run->motions[p] = run->motions[s->parents[p]];
      turnFirst(&run->motions[p], &turn);
      if (!placePiece(s, member, p, &run->motions[p])) {
        return false;
      }
    }
  }
  return true;
}

static void copySide(const LoopShape* s, const LoopMember* from, LoopMember* to, int body) {
  for (int p = s->pathCount; p < s->jointCount; p++) {
    if (s->bodies[p] == body) {
      copyPiece(s, from, to, p);
    }
  }
}

static void removeSide(const LoopShape* s, LoopMember* member, int body) {
  for (int p = s->pathCount; p < s->jointCount; p++) {
    member->isPlaced[p] = member->isPlaced[p] && s->bodies[p] != body;
  }
}

/* Tries draws of what hangs on a piece of the path, and keeps a free one. Returns the share of free ones. */
static double growSide(Run* run, LoopMember* member, int body) {
  const LoopShape* s = run->shape;
  bool hasSide = false, isDrawn = false;
  for (int p = s->pathCount; p < s->jointCount; p++) {
    hasSide = hasSide || s->bodies[p] == body;
    isDrawn = isDrawn || (s->bodies[p] == body && s->setOf[p] != -1);
  }
  if (!hasSide) {
    return 1;
  }
  Tries tries = {.most = isDrawn ? run->how->sideDraws : 1, .wanted = WANTED_SIDES};
  while (hasNext(&tries)) {
    if (placeSide(run, member, body) && keepsTry(run, &tries, 1)) {
      copySide(s, member, &run->chosenSide, body);
    }
    removeSide(s, member, body);
  }
  if (tries.sum > 0) {
    copySide(s, &run->chosenSide, member, body);
  }
  return meanOfTries(&tries);
}

/* ---- Pieces of the path ---- */

/* Places pieces of the path, whose motions are known, and then what hangs on them. Returns the share of free draws of
 * side chains; if it is 0, some pieces may be placed. */
static double placePath(Run* run, LoopMember* member, int first, int last) {
  for (int p = first; p <= last; p++) {
    if (!placePiece(run->shape, member, p, &run->motions[p])) {
      return 0;
    }
  }
  double share = 1;
  for (int p = first; p <= last && share > 0; p++) {
    share *= growSide(run, member, p);
  }
  return share;
}

static void copyPath(const LoopShape* s, const LoopMember* from, LoopMember* to, int first, int last) {
  for (int p = first; p <= last; p++) {
    copyPiece(s, from, to, p);
    copySide(s, from, to, p);
  }
}

static void copyTurns(const LoopMember* from, LoopMember* to, int first, int last) {
  memcpy(to->turns + first, from->turns + first, (size_t)(last - first + 1) * sizeof *to->turns);
}

static void removePath(const LoopShape* s, LoopMember* member, int first, int last) {
  for (int p = first; p <= last; p++) {
    member->isPlaced[p] = false;
    removeSide(s, member, p);
  }
}

/* The motions of pieces that joints from `first` to `last` turn, as seen from the end from which the loop grows.
 * Returns that of the last of them. */
static Turning turnPath(Run* run, const GrowthStep* step, const LoopMember* member) {
  Turning motion = step->isFromHead ? member->head : member->tail;
  if (step->isFromHead) {
    for (int j = step->first; j <= step->last; j++) {
      const Turning turn = turnOf(run->shape, j, member->turns[j]);
      turnFirst(&motion, &turn);
      run->motions[j + 1] = motion;
    }
  } else {
    for (int j = step->last; j >= step->first; j--) {
      const Turning turn = turnOf(run->shape, j, -member->turns[j]);
      turnFirst(&motion, &turn);
      run->motions[j] = motion;
    }
  }
  return motion;
}

/* How often the joints that remain after a step bring the ends together from where they are. */
static double guideOf(const LoopShape* s, const GrowthStep* step, const LoopMember* member) {
  double x1[3], u1[3], x2[3], u2[3];
  turnPoint(&member->head, s->points[step->headJoint], x1);
  turnDirection(&member->head, s->axes[step->headJoint], u1);
  turnPoint(&member->tail, s->points[step->tailJoint], x2);
  turnDirection(&member->tail, s->axes[step->tailJoint], u2);
  return step->meetings->values[binOfMeeting(step->meetings, x1, u1, x2, u2)];
}

/* ---- Closing ---- */

/* Turns the closing joints. False if the ends do not meet. */
static bool turnClosing(Run* run, const LoopMember* member) {
  const LoopShape* s = run->shape;
  Turning motion = member->head;
  for (int j = run->steps->closingFirst; j <= run->steps->closingLast; j++) {
    const Turning turn = turnOf(s, j, member->turns[j]);
    turnFirst(&motion, &turn);
    run->motions[j + 1] = motion;
  }
  double gap = 0;
  for (int k = 0; k < 3; k++) {
    gap += fabs(motion.t[k] - member->tail.t[k]);
    for (int l = 0; l < 3; l++) {
      gap += fabs(motion.r[k][l] - member->tail.r[k][l]);
    }
  }
  return gap < CLOSED;
}

static bool isPivot(const LoopSteps* steps, int joint) {
  bool isOne = false;
  for (int k = 0; k < CT_PIVOTS; k++) {
    isOne = isOne || steps->pivots[k] == joint;
  }
  return isOne;
}

/* The target density of the closing joints: that of their sets, and 1/|J|. */
static double closingDensity(const Run* run, const LoopMember* member) {
  double density = exp(-logJacobianOf(run->shape, run->steps, member->turns));
  for (int k = 0; k < CT_PIVOTS; k += 2) {
    const int set = run->shape->setOf[run->steps->pivots[k]];
    density *= densityOf(run->shape, &run->shape->sets[set], member->turns);
  }
  return isfinite(density) ? density : 0;
}

/* Joins the ends in one of all free ways, which `joined` receives by its target density. Returns their sum. */
static double join(Run* run, LoopMember* member) {
  const LoopShape* s = run->shape;
  const LoopSteps* steps = run->steps;
  const int first = steps->closingFirst + 1, last = steps->closingLast;
  for (int j = steps->closingFirst; j <= steps->closingLast; j++) {
    const int set = s->setOf[j];
    if (set != -1 && s->sets[set].joints[0] == j && !isPivot(steps, j)) {
      drawSet(run, &s->sets[set], member->turns);
    }
  }
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  const int count = findJoins(s, steps, &member->head, &member->tail, member->turns, solutions);
  double sum = 0;
  for (int i = 0; i < count; i++) {
    for (int k = 0; k < CT_PIVOTS; k++) {
      member->turns[steps->pivots[k]] = solutions[i][k];
    }
    const double share = turnClosing(run, member) ? placePath(run, member, first, last) : 0;
    const double value = share > 0 ? share * closingDensity(run, member) : 0;
    sum += value;
    if (value > 0 && draw(run) * sum < value) {
      copyPath(s, member, &run->joined, first, last);
      copyTurns(member, &run->joined, steps->closingFirst, steps->closingLast);
    }
    removePath(s, member, first, last);
  }
  return sum;
}

/* ---- Steps ---- */

/* Makes a step by trying draws. The weight is 0 if none is free. The last step is made with the joints that close. */
static void growStep(Run* run, const GrowthStep* step, bool isLast, LoopMember* member) {
  const LoopShape* s = run->shape;
  const int first = step->isFromHead ? step->first + 1 : step->first;
  const int last = step->isFromHead ? step->last + 1 : step->last;
  const Turning before = step->isFromHead ? member->head : member->tail;
  Turning* const end = step->isFromHead ? &member->head : &member->tail;
  Turning chosenEnd = before;
  double chosenGuide = 1;
  Tries tries = {.most = step->set == -1 ? 1 : run->how->backboneDraws, .wanted = step->set == -1 ? 2 : WANTED};
  if (isLast) { /* few of the closing joints' values are likely, so that weights differ most here */
    tries.most = LAST_FACTOR * run->how->backboneDraws;
    tries.wanted = LAST_FACTOR * WANTED;
  }
  while (hasNext(&tries)) {
    if (step->set != -1) {
      drawSet(run, &s->sets[step->set], member->turns);
    }
    *end = turnPath(run, step, member);
    const double guide = guideOf(s, step, member);
    const double chance = step->first > step->last ? 1 : fmin(guide / ENOUGH, 1);
    double value = chance < 1 && draw(run) >= chance ? 0 : placePath(run, member, first, last) / chance;
    if (value > 0) {
      value *= isLast ? join(run, member) : guide;
    }
    if (value > 0 && keepsTry(run, &tries, value)) {
      copyPath(s, member, &run->chosen, first, last);
      copyTurns(member, &run->chosen, step->first, step->last);
      if (isLast) {
        copyPath(s, &run->joined, &run->chosen, run->steps->closingFirst + 1, run->steps->closingLast);
        copyTurns(&run->joined, &run->chosen, run->steps->closingFirst, run->steps->closingLast);
      }
      chosenEnd = *end;
      chosenGuide = isLast ? 1 : guide;
    }
    removePath(s, member, first, last);
    *end = before;
  }
  member->weight *= meanOfTries(&tries) / member->guide;
  if (tries.sum > 0) {
    copyPath(s, &run->chosen, member, first, last);
    copyTurns(&run->chosen, member, step->first, step->last);
    if (isLast) {
      copyPath(s, &run->chosen, member, run->steps->closingFirst + 1, run->steps->closingLast);
      copyTurns(&run->chosen, member, run->steps->closingFirst, run->steps->closingLast);
    }
    *end = chosenEnd;
    member->guide = chosenGuide;
  }
}

/* ---- Populations ---- */

/* The sum of weights, and the effective number of members. */
static double sumWeights(const LoopMember* members, int count, double* effective) {
  double sum = 0, squares = 0;
  for (int i = 0; i < count; i++) {
    sum += members[i].weight;
    squares += members[i].weight * members[i].weight;
  }
  *effective = squares > 0 ? sum * sum / squares : 0;
  return sum;
}

/* Draws a population of equal weights from one of sum `sum`, at equal distances of the summed weights. */
static void drawMembers(const Run* run, const LoopMember* from, LoopMember* to, int count, double sum) {
  const double offset = draw(run);
  double passed = 0;
  int drawn = 0;
  for (int i = 0; i < count; i++) {
    passed += from[i].weight;
    while (drawn < count && (drawn + offset) * sum < passed * count) {
      copyLoopMember(run->shape, &from[i], &to[drawn]);
      to[drawn++].weight = 1;
    }
  }
  while (drawn < count) { /* by rounding */
    copyLoopMember(run->shape, &to[drawn - 1], &to[drawn]);
    drawn++;
  }
}

/* Grows a population. Returns the member that is drawn from it, or NULL if all have died out. */
static const LoopMember* growPopulation(Run* run, LoopMember* members, LoopMember* others, double* logWeight) {
  const int count = run->how->population;
  for (int i = 0; i < count; i++) {
    resetLoopMember(run->shape, &members[i]);
  }
  *logWeight = 0;
  double sum = count;
  for (int step = 0; step < run->steps->count; step++) {
    const bool isLast = step == run->steps->count - 1;
    for (int i = 0; i < count; i++) {
      if (members[i].weight > 0) {
        growStep(run, &run->steps->steps[step], isLast, &members[i]);
      }
    }
    double effective;
    sum = sumWeights(members, count, &effective);
    if (!(sum > 0)) {
      return NULL;
    }
    if (!isLast && effective < LEAST_EFFECTIVE * count) {
      *logWeight += log(sum / count);
      drawMembers(run, members, others, count, sum);
      LoopMember* const drawn = others;
      others = members;
      members = drawn;
      sum = count;
    }
  }
  *logWeight += log(sum / count);
  double place = draw(run) * sum;
  int last = 0;
  for (int i = 0; i < count && place >= 0; i++) {
    if (members[i].weight > 0) {
      last = i;
      place -= members[i].weight;
    }
  }
  return &members[last];
}

static void report(const LoopShape* s, const LoopMember* member, double (*positions)[3], double* angles,
                   double* logDensity) {
  for (int i = 0; i < s->particleCount; i++) {
    memcpy(positions[s->order[i]], member->places[i], sizeof *positions);
  }
  for (int j = 0; j < s->jointCount; j++) {
    angles[j] = wrap(s->angles[j] + member->turns[j]);
  }
  *logDensity = 0;
  for (int i = 0; i < s->setCount; i++) {
    *logDensity += log(densityOf(s, &s->sets[i], member->turns));
  }
}

bool ctGrow(const ctGrowth* growth, const ctGrowthRun* how, double (*positions)[3], double* angles, double* logWeight,
            double* logDensity, bool* hasMemory) {
  const LoopShape* s = &growth->shape;
  const int count = how->population;
  Run run = {.shape = s, .steps = &growth->steps, .how = how};
  LoopMember* members = calloc(2 * (size_t)count, sizeof *members);
  run.motions = malloc((size_t)(s->jointCount + 1) * sizeof *run.motions);
  *hasMemory = members != NULL && run.motions != NULL;
  *hasMemory = makeLoopMember(s, &run.chosen) && *hasMemory;
  *hasMemory = makeLoopMember(s, &run.chosenSide) && *hasMemory;
  *hasMemory = makeLoopMember(s, &run.joined) && *hasMemory;
  for (int i = 0; members != NULL && i < 2 * count; i++) {
    *hasMemory = makeLoopMember(s, &members[i]) && *hasMemory;
  }
  const LoopMember* grown = *hasMemory ? growPopulation(&run, members, members + count, logWeight) : NULL;
  if (grown != NULL) {
    report(s, grown, positions, angles, logDensity);
  }
  for (int i = 0; members != NULL && i < 2 * count; i++) {
    freeLoopMember(&members[i]);
  }
  freeLoopMember(&run.chosen);
  freeLoopMember(&run.chosenSide);
  freeLoopMember(&run.joined);
  free(members);
  free(run.motions);
  return grown != NULL;
}
