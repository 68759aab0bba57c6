/* How many pairs of volumes and of particles are tested in fixed races. They are what the benchmark's tables say of a
 * contestant, so a change of it, or of the engine, must not change them unseen. They are the same on all instruction
 * sets; only the SIMD grid's, which depend on how many lanes there are, are not among them. */
#include "branches.h"
#include "chains.h"
#include "race.h"
#include "sets.h"

enum { RACES = 3 };

typedef struct Expected {
  const char* name;
  int64_t counts[RACES][2]; /* of volumes and of particles */
} Expected;

static const Expected expected[] = {
    {"ours", {{95365, 101640}, {171244, 196358}, {41200, 37342}}},
    {"published", {{180219, 2120}, {114552, 5283}, {474466, 953771}}},
    {"improved", {{30083, 1407}, {28174, 2530}, {38258, 43048}}},
    {"kobbtree", {{22834, 258}, {83198, 318}, {41856, 6121}}},
    {"obbtree1", {{629824, 1269}, {1335821, 3164}, {1142005, 244053}}},
    {"fullgrid", {{0, 354336}, {0, 579858}, {0, 1248764}}},
    {"lazygrid", {{0, 71634}, {0, 334270}, {0, 40929}}},
    {"verletlist", {{0, 378120}, {0, 1107358}, {0, 41099}}},
    {"brute", {{0, 19478098}, {0, 20702766}, {0, 75709}}},
};

enum { CONTESTANTS = sizeof expected / sizeof expected[0] };

static void checkRace(int number, const Scene* scene, MoveRule rule, const InstructionSet* set) {
  Race race = {.scene = scene,
               .rule = rule,
               .seed = 1,
               .trialCount = 400,
               .blockSize = 100,
               .judge = contestantFind(set, "lazygrid")};
  RaceResult results[MOST_LANES];
  char error[200] = "";
  for (int i = 0; i < CONTESTANTS; i++) {
    race.contestants[race.laneCount++] = contestantFind(set, expected[i].name);
  }
  if (!raceRun(&race, results, error, sizeof error)) {
    reportFailure("race %d: %s\n", number, error);
    return;
  }
  const int run = race.trialCount + race.blockSize; /* with trials that are not timed */
  for (int i = 0; i < CONTESTANTS; i++) {
    const long long volumes = llround(results[i].volumeTests * run);
    const long long particles = llround(results[i].particleTests * run);
    const int64_t* wanted = expected[i].counts[number];
    if (volumes != wanted[0] || particles != wanted[1]) {
      reportFailure("race %d, %s, %s: %lld and %lld, not %lld and %lld\n", number, set->name, expected[i].name, volumes,
                    particles, (long long)wanted[0], (long long)wanted[1]);
    }
  }
}

int main(void) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  Random random = {1};
  Scene* chain = chainRandom(500, &random);
  Scene* compact = chainHilbert(512);
  Scene* branches = makeBranches(MOST_BRANCH_LINKS, 4, 3);
  for (int i = 0; i < setCount; i++) {
    checkRace(0, chain, (MoveRule){movesUniform, 0, 1}, sets[i]);
    checkRace(1, compact, (MoveRule){movesGaussian, 0.1, 2}, sets[i]);
    checkRace(2, branches, (MoveRule){movesUniform, 0, 1}, sets[i]);
  }
  sceneFree(chain);
  sceneFree(compact);
  sceneFree(branches);
  return checkResult();
}
