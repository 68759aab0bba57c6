/* Random numbers that are the same on every machine: splitmix64. */
#ifndef RANDOM_H_
#define RANDOM_H_

#include <math.h>
#include <stdint.h>

#define PI 3.14159265358979323846

typedef struct Random {
  uint64_t state;
} Random;

static inline uint64_t randomBits(Random* random) {
  uint64_t z = random->state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* In [0, 1). */
static inline double randomReal(Random* random) {
  return (double)(randomBits(random) >> 11) * 0x1p-53;
}

/* In 0 ... count - 1. */
static inline int randomInt(Random* random, int count) {
  return (int)(randomReal(random) * count);
}

/* Of mean 0 and variance 1. */
static inline double randomGaussian(Random* random) {
  const double radius = sqrt(-2 * log(1 - randomReal(random)));
  return radius * cos(2 * PI * randomReal(random));
}

#endif /* RANDOM_H_ */
