#include "whole.h"

#include <stdlib.h>

static bool repeat(const Contestant* contestant, void* self, int repeats, double* times, WholeResult* result) {
  for (int i = 0; i < repeats; i++) {
    const Counts before = contestant->counts(self);
    const double start = processorTime();
    const int clash = contestant->testAll(self);
    times[i] = processorTime() - start;
    if (clash < 0) {
      return false;
    }
    const Counts after = contestant->counts(self);
    result->clash = clash > 0;
    result->counts = (Counts){after.volumeTests - before.volumeTests, after.particleTests - before.particleTests,
                              after.updates - before.updates};
  }
  result->instructionSet = contestant->instructionSet == NULL ? NULL : contestant->instructionSet(self);
  result->microseconds = quartilesOf(times, repeats);
  return true;
}

bool wholeRun(const Scene* scene, const Contestant* contestant, int repeats, WholeResult* result) {
  void* self = contestant->make(scene);
  double* times = calloc((size_t)repeats, sizeof(double));
  const bool success = self != NULL && times != NULL && repeat(contestant, self, repeats, times, result);
  contestant->destroy(self);
  free(times);
  return success;
}
