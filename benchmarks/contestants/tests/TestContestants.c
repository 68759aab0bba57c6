/* Every contestant, in every instruction set that is here, gives the verdicts of all pairs, trial after trial, whether
 * trials are taken over or not.
 *
 * Usage: TestContestants [trials of a scene].
 */
#include <math.h>
#include <stdlib.h>

#include "branches.h"
#include "chains.h"
#include "rigid.h"
#include "sets.h"

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
static void checkPositions(const Scene* scene, const Sphere* found, const Sphere* expected) {
  for (int i = 1; i < scene->particleCount; i++) {
    for (int j = 0; j < i; j += 1 + i / 20) {
      const double distance = sqrt(squaredDistance(found[i].x, found[j].x));
      CHECK(fabs(distance - sqrt(squaredDistance(expected[i].x, expected[j].x))) < 1e-9);
    }
  }
}

static void testScene(const char* name, Scene* scene, double width, uint64_t seed) {
  Rival rivals[MOST_RIVALS];
  Random random = {seed};
  const int count = gatherRivals(scene, rivals);
  const InstructionSet* portable = instructionSetFind("portable");
  const Contestant* brute = contestantFind(portable, "brute");
  void* judge = brute->make(scene);
  int clashes = 0;
  for (int trial = 0; trial < trialCount; trial++) {
    Turn turns[8];
    const int turnCount = randomTurns(scene, width, &random, turns);
    const bool expected = brute->test(judge, turnCount, turns);
    const bool taken = !expected && randomInt(&random, 3) > 0;
    clashes += expected;
    if (taken) {
      brute->accept(judge);
    }
    for (int i = 0; i < count; i++) {
      const Rival* rival = &rivals[i];
      const bool clash = rival->contestant->test(rival->self, turnCount, turns);
      if (clash != expected) {
        reportFailure("%s, trial %d: %s (%s) says %d, not %d\n", name, trial, rival->contestant->name, rival->set->name,
                      clash, expected);
      }
      if (taken) {
        rival->contestant->accept(rival->self);
      } else {
        rival->contestant->reject(rival->self);
      }
    }
  }
  /* else nothing was tested */
  CHECK(clashes > trialCount / 50 && clashes < trialCount - trialCount / 50);
  for (int i = 0; i < count; i++) {
    if (rivals[i].contestant->spheres != NULL) {
      checkPositions(scene, rivals[i].contestant->spheres(rivals[i].self), brute->spheres(judge));
    }
    rivals[i].contestant->destroy(rivals[i].self);
  }
  brute->destroy(judge);
  sceneFree(scene);
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
  testScene("a few", chainRandom(7, &random), PI, 6);
  for (uint64_t seed = 0; seed < 6; seed++) {
    testScene("branches", makeBranches(MOST_BRANCH_LINKS, 1 + (int)seed * 4, seed), seed % 2 == 0 ? PI : 0.2, seed);
  }
  testScene("some branches", makeBranches(9, 3, 7), PI, 7);
  return checkResult();
}
