/* How many pairs of volumes and of particles are tested in fixed races. They are what the benchmark's tables say of a
 * contestant, so a change of it, or of the engine, must not change them unseen. They are the same on all instruction
 * sets; only the SIMD grid's, which depend on how many lanes there are, are not among them. */
#include <string.h>

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
    {"ours", {{113541, 142666}, {122696, 143338}, {22486, 131710}}},
    {"ours-avx512", {{113541, 142666}, {122696, 143338}, {22486, 131710}}},
    {"ours-avx2", {{113541, 142666}, {122696, 143338}, {22486, 131710}}},
    {"ours-portable", {{113541, 142666}, {122696, 143338}, {22486, 131710}}},
    {"ours-tree", {{115924, 114969}, {124902, 110369}, {43860, 70571}}},
    {"ours-boxes", {{107885, 92921}, {124221, 109752}, {40787, 70379}}},
    {"ours-clearances", {{58689, 8267329}, {17804, 746786}, {955, 934949}}},
    {"published", {{193201, 5259}, {132472, 5128}, {242857, 101718}}},
    {"published-selves-first", {{178623, 5119}, {127670, 5095}, {212544, 93070}}},
    {"published-tight", {{79611, 3435}, {62652, 3532}, {99411, 52722}}},
    {"published-capsules", {{117261, 1319}, {138872, 952}, {112725, 26476}}},
    {"published-spheres", {{188099, 24739}, {292280, 47664}, {197545, 109280}}},
    {"improved", {{37514, 1663}, {28286, 1699}, {31133, 10512}}},
    {"kobbtree", {{25403, 285}, {46298, 185}, {18253, 1008}}},
    {"kobbtree-leaves", {{18067, 42817}, {33924, 80205}, {8518, 29148}}},
    {"obbtree1", {{639267, 3017}, {1108607, 3209}, {337196, 51516}}},
    {"obbtree1-leaves", {{232637, 2008591}, {381941, 3806369}, {55978, 605394}}},
    {"fullgrid", {{0, 322644}, {0, 544143}, {0, 324721}}},
    {"lazygrid", {{0, 66240}, {0, 345965}, {0, 51521}}},
    {"verletlist", {{0, 350359}, {0, 1183987}, {0, 125646}}},
    {"brute", {{0, 19167851}, {0, 22752081}, {0, 527707}}},
};

enum { CONTESTANTS = sizeof expected / sizeof expected[0] };

static void checkRace(int number, const Scene* scene, MoveRule rule, const InstructionSet* set) {
  Race race = {.scene = scene,
               .rule = rule,
               .seed = 1,
               .trialCount = 500,
               .blockSize = 500,
               .seconds = INFINITY,
               .judge = contestantFind(set, "lazygrid", strlen("lazygrid"))};
  RaceResult results[MOST_LANES];
  char error[200] = "";
  for (int i = 0; i < CONTESTANTS; i++) {
    race.contestants[race.laneCount++] = precisionFind(set, expected[i].name, strlen(expected[i].name));
  }
  if (!raceRun(&race, results, error, sizeof error)) {
    reportFailure("race %d: %s\n", number, error);
    return;
  }
  for (int i = 0; i < CONTESTANTS; i++) {
    const long long volumes = llround(results[i].volumeTests * race.trialCount);
    const long long particles = llround(results[i].particleTests * race.trialCount);
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
