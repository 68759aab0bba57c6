/* Times, and what is made of them. */
#ifndef MEASURE_H_
#define MEASURE_H_

/* Microseconds of processor time of this program, which has one thread. */
double processorTime(void);

/* Sorts the values; 0 if there are none. */
double medianOf(double* values, int count);

#endif /* MEASURE_H_ */
