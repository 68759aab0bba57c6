/* Times, and what is made of them. */
#ifndef MEASURE_H_
#define MEASURE_H_

/* Microseconds of processor time of this program, which has one thread. */
double processorTime(void);

typedef struct Quartiles {
  double first;
  double median;
  double third;
} Quartiles;

/* Sorts the values; count > 0. */
Quartiles quartilesOf(double* values, int count);

#endif /* MEASURE_H_ */
