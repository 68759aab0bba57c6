/* How trials are tested for clashes: by testers, each of which knows when it is worth its cost. They are tried in turn
 * until one decides. None of them changes a verdict, only the time that it takes. */
#ifndef CT_TESTER_H_
#define CT_TESTER_H_

#include "traverse.h"

/* In the order in which they are tried. */
typedef enum TesterId {
  FEW_MOVERS,     /* the few slots that move, one by one, against all others: "fewMovers" */
  RECENT_CLASHES, /* pairs that have clashed in past trials: "recentClashes" */
  CLEARANCES,     /* leaves that may come together, by a table of clearances: "clearances" */
  DESCENT,        /* the whole tree against itself: "descent" */
  TESTER_COUNT
} TesterId;

typedef enum Outcome {
  undecided, /* the next tester decides */
  isFree,
  isClash,
  failed /* there was no memory */
} Outcome;

/* Tests a view of the open trial. If it clashes, `slots` get a pair that does. */
Outcome ctTestView(ctChainTree* scene, const View* view, int slots[2], ctCounts* counts);

/* Call before the open trial becomes the state. */
void ctTestersAccept(ctChainTree* scene);

/* Call when the state or the limits change otherwise. */
void ctTestersForget(ctChainTree* scene);

/* Switches off testers as the environment asks, see ctGetInstructionSet. */
void ctChooseTesters(ctChainTree* scene);

/* Switches a tester on or off, for tests and benchmarks; false if none has this name. Without the descent, clearances
 * are used whatever they cost; where no other tester can decide, the descent still does. */
bool ctSwitchTester(ctChainTree* scene, const char* name, bool isOn);

#endif /* CT_TESTER_H_ */
