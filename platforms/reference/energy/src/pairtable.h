/* Functions of one to three numbers by tables; see ctTable. */
#ifndef CT_PAIRTABLE_H_
#define CT_PAIRTABLE_H_

#include <math.h>

#include "ctenergy.h"

/* The value of a discrete table for as many of three numbers as it has dimensions. */
static inline double discreteValue(const ctTable* table, const double* numbers) {
  size_t at = 0;
  size_t step = 1;
  for (int d = 0; d < table->dimensions; d++) {
    if (!(numbers[d] > -0.5 && numbers[d] < table->sizes[d] - 0.5)) {
      return NAN;
    }
    at += step * (size_t)(numbers[d] + 0.5);
    step *= (size_t)table->sizes[d];
  }
  return table->values[at];
}

/* The interval of dimension d that a number is in, and where in it, from 0 to 1. False if it is in none. */
static inline bool findInterval(const ctTable* table, int d, double number, size_t* interval, double* within) {
  const double low = table->minima[d];
  const double width = table->maxima[d] - low;
  double part = (number - low) / width;
  if (table->isPeriodic) {
    part -= floor(part);
  }
  if (!(part >= 0 && part <= 1)) {
    return false;
  }
  const int size = table->sizes[d];
  const double place = part * size;
  const int begin = place < size ? (int)place : size - 1;
  *interval = (size_t)begin;
  *within = place - begin;
  return true;
}

static inline double cubicAt(const double* c, double u) {
  return c[0] + u * (c[1] + u * (c[2] + u * c[3]));
}

static inline double pieceValue(const ctTable* table, const double* numbers) {
  size_t interval[2] = {0, 0};
  double within[2] = {0, 0};
  for (int d = 0; d < table->dimensions; d++) {
    if (!findInterval(table, d, numbers[d], &interval[d], &within[d])) {
      return isfinite(numbers[d]) || (isinf(numbers[d]) && !table->isPeriodic) ? 0 : NAN;
    }
  }
  if (table->dimensions == 1) {
    return cubicAt(table->values + 4 * interval[0], within[0]);
  }
  const double* c = table->values + 16 * (interval[0] + (size_t)table->sizes[0] * interval[1]);
  double rows[4];
  for (int i = 0; i < 4; i++) {
    rows[i] = cubicAt(c + 4 * i, within[1]);
  }
  return cubicAt(rows, within[0]);
}

static inline double tableValue(const ctTable* table, double x, double y, double z) {
  const double numbers[3] = {x, y, z};
  return table->isDiscrete ? discreteValue(table, numbers) : pieceValue(table, numbers);
}

/* How many numbers a table has. */
static inline size_t tableLength(const ctTable* table) {
  size_t length = table->isDiscrete ? 1 : table->dimensions == 1 ? 4 : 16;
  for (int d = 0; d < table->dimensions; d++) {
    length *= (size_t)table->sizes[d];
  }
  return length;
}

#endif /* CT_PAIRTABLE_H_ */
