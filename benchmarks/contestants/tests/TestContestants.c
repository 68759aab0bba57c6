/* Every contestant, in every instruction set that is here, gives the verdicts of all pairs, trial after trial, whether
 * trials are taken over or not.
 *
 * Usage: TestContestants [trials of a scene].
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "branches.h"
#include "chains.h"
#include "sets.h"

enum { MOST_PARTICLES = 200 };

static int trialCount = 400;

typedef struct Rival {
  const InstructionSet* set;
  const Contestant* contestant;
  void* self;
} Rival;

enum { MOST_RIVALS = 100 };

static int gatherRivals(const Scene* scene, Rival* rivals) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  int count = 0;
  for (int i = 0; i < setCount; i++) {
    if (i > 0 && sets[i]->contestants == sets[i - 1]->contestants) {
      continue;
    }
    for (const Contestant* const* c = sets[i]->contestants; *c != NULL; c++) {
      rivals[count++] = (Rival){sets[i], *c, (*c)->make(scene)};
      CHECK(rivals[count - 1].self != NULL);
    }
  }
  return count;
}

static int randomTurns(const Scene* scene, double width, Random* random, Turn* turns) {
  const int most = scene->torsionCount < 8 ? scene->torsionCount : 8;
  const int count = randomInt(random, 2) == 0 ? 1 : 1 + randomInt(random, most);
  for (int i = 0; i < count; i++) {
    bool isNew = false;
    while (!isNew) {
      turns[i].torsion = randomInt(random, scene->torsionCount);
      isNew = true;
      for (int k = 0; k < i; k++) {
        isNew = isNew && turns[k].torsion != turns[i].torsion;
      }
    }
    turns[i].angle = width * (2 * randomReal(random) - 1);
  }
  return count;
}

/* Distances are the same up to rounding: what moves is right, and so is what stays. */
static void checkPositions(const Scene* scene, const Rival* rival, const Sphere* expected) {
  Sphere workedOut[MOST_PARTICLES];
  const Sphere* spheres = workedOut;
  if (rival->contestant->spheres != NULL) {
    spheres = rival->contestant->spheres(rival->self);
  } else {
    double coordinates[3 * MOST_PARTICLES];
    rival->contestant->positions(rival->self, coordinates);
    for (int i = 0; i < scene->particleCount; i++) {
      memcpy(workedOut[i].x, coordinates + 3 * i, sizeof workedOut[i].x);
    }
  }
  for (int i = 1; i < scene->particleCount; i++) {
    for (int j = 0; j < i; j += 1 + i / 20) {
      double difference = 0;
      for (int side = 0; side < 2; side++) {
        const Sphere* s = side == 0 ? spheres : expected;
        const double d = hypot(hypot(s[i].x[0] - s[j].x[0], s[i].x[1] - s[j].x[1]), s[i].x[2] - s[j].x[2]);
        difference += side == 0 ? d : -d;
      }
      CHECK(fabs(difference) < 1e-9);
    }
  }
}

static void testScene(const char* name, Scene* scene, double width, uint64_t seed) {
  Rival rivals[MOST_RIVALS];
  Random random = {seed};
  const int count = gatherRivals(scene, rivals);
  const InstructionSet* portable = instructionSetFind("portable");
  const Contestant* brute = contestantFind(portable, "brute", strlen("brute"));
  void* judge = brute->make(scene);
  int clashes = 0;
  for (int trial = 0; trial < trialCount; trial++) {
    Turn turns[8];
    const int turnCount = randomTurns(scene, width, &random, turns);
    const int expected = brute->test(judge, turnCount, turns);
    const bool taken = expected == 0 && randomInt(&random, 3) > 0;
    clashes += expected;
    if (taken) {
      CHECK(brute->accept(judge));
    }
    for (int i = 0; i < count; i++) {
      const Rival* rival = &rivals[i];
      const int clash = rival->contestant->test(rival->self, turnCount, turns);
      if (clash != expected) {
        reportFailure("%s, trial %d: %s (%s) says %d, not %d\n", name, trial, rival->contestant->name, rival->set->name,
                      clash, expected);
      }
      if (taken) {
        CHECK(rival->contestant->accept(rival->self));
      } else {
        rival->contestant->reject(rival->self);
      }
    }
  }
  /* else nothing was tested */
  CHECK(clashes > trialCount / 50 && clashes < trialCount - trialCount / 50);
  for (int i = 0; i < count; i++) {
    checkPositions(scene, &rivals[i], brute->spheres(judge));
    rivals[i].contestant->destroy(rivals[i].self);
  }
  brute->destroy(judge);
  sceneFree(scene);
}

/* Whole chains, with clashes and without: some of the spheres are made larger. */
static void testWholeChains(void) {
  int clashes = 0;
  for (uint64_t seed = 0; seed < 30; seed++) {
    Rival rivals[MOST_RIVALS];
    Random random = {seed};
    Scene* scene = seed % 2 == 0 ? chainRandom(150, &random) : makeBranches(40, 5, seed);
    const int grown = randomInt(&random, scene->particleCount);
    scene->spheres[grown].radius *= seed % 2 == 0 ? 4 * randomReal(&random) : 1.3;
    const int count = gatherRivals(scene, rivals);
    int expected = -1;
    for (int i = 0; i < count; i++) {
      if (rivals[i].contestant->testAll != NULL) {
        const int clash = rivals[i].contestant->testAll(rivals[i].self);
        expected = expected < 0 ? clash : expected;
        CHECK(clash == expected);
      }
      rivals[i].contestant->destroy(rivals[i].self);
    }
    clashes += expected;
    sceneFree(scene);
  }
  CHECK(clashes >= 5 && clashes <= 25);
}

int main(int argumentCount, char** arguments) {
  if (argumentCount > 1) {
    trialCount = atoi(arguments[1]);
  }
  Random random = {1};
  testScene("random, large turns", chainRandom(100, &random), PI, 1);
  testScene("random, small turns", chainRandom(200, &random), 0.1, 2);
  testScene("hilbert", chainHilbert(150), 0.5, 3);
  testScene("serpentine", chainSerpentine(130), PI, 4);
  testScene("worst", chainWorstCase(200), 0.3, 5);
  testScene("a few", chainRandom(7, &random), PI, 6);
  for (uint64_t seed = 0; seed < 6; seed++) {
    testScene("branches", makeBranches(MOST_BRANCH_LINKS, 1 + (int)seed * 4, seed), seed % 2 == 0 ? PI : 0.2, seed);
  }
  testScene("some branches", makeBranches(9, 3, 7), PI, 7);
  testWholeChains();
  return checkResult();
}
