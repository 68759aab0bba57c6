/* Trials stop where they are said to, and wrong verdicts are counted, those of contestants that are known to err among
 * them. */
#define REAL long double

#include <string.h>

#include "branches.h"
#include "chains.h"
#include "contacts.h"
#include "reference.h"
#include "rigid.h"
#include "sets.h"
#include "touchrace.h"

/* ---- Contacts ---- */

/* The largest overlap of what a turn moves and what not, of all pairs. */
static long double largestOverlap(const Scene* scene, const Place* places, const Turn* turn) {
  const Torsion* torsion = &scene->torsions[turn->torsion];
  const Rigid motion = rigidTurn(places[torsion->axis[0]], places[torsion->axis[1]], turn->angle);
  long double largest = -INFINITY;
  for (int j = torsion->first; j < torsion->last; j++) {
    Place moved;
    rigidApply(&motion, places[j], moved);
    for (int i = 0; i < scene->particleCount; i++) {
      const bool isOnAxis = i == torsion->axis[0] || j == torsion->axis[1];
      if ((i < torsion->first || i >= torsion->last) && !isOnAxis && !sceneExcludes(scene, i, j)) {
        const long double distance = sqrt(squaredDistance(places[i], moved));
        largest = fmax(largest, scene->spheres[i].radius + (long double)scene->spheres[j].radius - distance);
      }
    }
  }
  return largest;
}

static void checkContacts(const Scene* scene, const Place* places, int count) {
  const InstructionSet* set = instructionSetFind(NULL);
  const Contestant* judge = contestantFind(set, "lazygrid", strlen("lazygrid"));
  void* self = judge->make(scene);
  Random random = {3};
  for (int k = 0; k < count; k++) {
    Contact contact;
    CHECK(contactFind(scene, places, judge, self, &random, &contact) == contactFound);
    for (int sign = -1; sign <= 1; sign += 2) {
      const double wanted = sign * 1e-6;
      double angle;
      if (contactAngle(scene, places, &contact, wanted, &angle)) {
        const Turn turn = {contact.torsion, angle};
        const long double overlap = contactOverlap(scene, places, &contact, angle);
        CHECK(overlap == largestOverlap(scene, places, &turn));
        /* Another pair may overlap more, where several touch. */
        CHECK(fabs(overlap - wanted) < 1e-13L || overlap > wanted);
      }
    }
    contactFree(&contact);
  }
  judge->destroy(self);
}

static void testContacts(void) {
  Place places[MOST_BRANCH_PARTICLES];
  Scene* chain = chainHilbert(120);
  Scene* branches = makeBranches(40, 4, 3);
  const Scene* scenes[2] = {chain, branches};
  for (int s = 0; s < 2; s++) {
    for (int i = 0; i < scenes[s]->particleCount; i++) {
      for (int k = 0; k < 3; k++) {
        places[i][k] = scenes[s]->spheres[i].x[k];
      }
    }
    checkContacts(scenes[s], (const Place*)places, 30);
  }
  sceneFree(chain);
  sceneFree(branches);
}

/* ---- Verdicts ---- */

static int callFree(void* self, int count, const Turn* turns) {
  (void)self;
  (void)count;
  (void)turns;
  return 0;
}

static void* makeNothing(const Scene* scene) {
  return (void*)scene;
}

static void doNothing(void* self) {
  (void)self;
}

static bool acceptAll(void* self) {
  (void)self;
  return true;
}

static const Contestant blind = {.name = "blind",
                                 .make = makeNothing,
                                 .destroy = doNothing,
                                 .test = callFree,
                                 .accept = acceptAll,
                                 .reject = doNothing};

static bool mayMiss(const char* name) {
  return strcmp(name, "volumes-single") == 0 || strcmp(name, "all-single") == 0 ||
         strcmp(name, "lazygrid-single") == 0 || strcmp(name, "blind") == 0;
}

static bool mayInvent(const char* name) {
  return strcmp(name, "all-single") == 0 || strcmp(name, "lazygrid-single") == 0;
}

static void testVerdicts(const InstructionSet* set) {
  Scene* scene = chainHilbert(150);
  TouchRace race = {.scene = scene,
                    .seed = 1,
                    .trialCount = 1000,
                    .seconds = 1e9,
                    .judge = contestantFind(set, "lazygrid", strlen("lazygrid"))};
  TouchResult results[MOST_TOUCH_LANES];
  char error[200] = "";
  for (const Contestant* const* c = set->precisions; *c != NULL; c++) {
    race.contestants[race.laneCount++] = *c;
  }
  race.contestants[race.laneCount++] = contestantFind(set, "brute", strlen("brute"));
  race.contestants[race.laneCount++] = &blind;
  if (!touchRaceRun(&race, results, error, sizeof error)) {
    reportFailure("%s: %s\n", set->name, error);
    return;
  }
  for (int i = 0; i < race.laneCount; i++) {
    const char* name = race.contestants[i]->name;
    const TouchResult* result = &results[i];
    CHECK(result->clashes > 400 && result->gaps > 400);
    if ((result->missed > 0) != mayMiss(name) || (result->invented > 0) != mayInvent(name)) {
      reportFailure("%s, %s: %d missed, %d invented\n", set->name, name, result->missed, result->invented);
    }
    CHECK((result->largestMissed > LEAST_TOUCH) == (result->missed > 0));
    CHECK((result->largestInvented > LEAST_TOUCH) == (result->invented > 0));
    CHECK(strcmp(name, "blind") != 0 || result->missed == result->clashes);
    CHECK(strcmp(name, "volumes-single") != 0 || result->largestMissed < 1e-6);
  }
  sceneFree(scene);
}

int main(void) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  if (!referenceIsExact()) {
    return 77;
  }
  testContacts();
  for (int i = 0; i < setCount; i++) {
    testVerdicts(sets[i]);
  }
  return checkResult();
}
