/* Contestants on the question whether a chain, as it is, clashes with itself anywhere. */
#ifndef WHOLE_H_
#define WHOLE_H_

#include "contestant.h"
#include "measure.h"

typedef struct WholeResult {
  const char* instructionSet; /* NULL if the contestant does not choose it */
  Quartiles microseconds;     /* per test */
  Counts counts;              /* of one test */
  bool clash;
} WholeResult;

/* Tests `repeats` times by a contestant with `testAll`; false if there is no memory. */
bool wholeRun(const Scene* scene, const Contestant* contestant, int repeats, WholeResult* result);

#endif /* WHOLE_H_ */
