/* Times, and what is made of them. */
#ifndef MEASURE_H_
#define MEASURE_H_

#include <stdint.h>

/* Microseconds of processor time of this program, which has one thread. */
double processorTime(void);

typedef struct Quartiles {
  double first;
  double median;
  double third;
} Quartiles;

/* Sorts the values; count > 0. */
Quartiles quartilesOf(double* values, int count);

/* Bytes that the process has allocated and not freed, as the C library counts them, to within a few kilobytes; -1 where
 * it does not tell. */
int64_t heapBytes(void);

#endif /* MEASURE_H_ */
