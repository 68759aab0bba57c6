#define _POSIX_C_SOURCE 200112L
#include "measure.h"

#include <stdlib.h>
#include <time.h>

/* The clock of the thread is read in half the time of that of the process. */
double processorTime(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * (double)now.tv_sec + 1e-3 * (double)now.tv_nsec;
}

static int compare(const void* a, const void* b) {
  const double x = *(const double*)a;
  const double y = *(const double*)b;
  return (x > y) - (x < y);
}

double medianOf(double* values, int count) {
  qsort(values, (size_t)count, sizeof(double), compare);
  return count == 0 ? 0 : 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}
