/* How far positions are from where they should be. */
#ifndef ERRORS_H_
#define ERRORS_H_

#include "random.h"
#include "scene.h"

typedef long double Place[3];

typedef struct Error {
  double largest;
  double rms;
} Error;

typedef struct Errors {
  Error distances; /* of pairs of particles, nm */
  Error bonds;     /* their lengths, nm */
  Error angles;    /* between bonds, rad */
  Error torsions;  /* rad; those of straight bonds left out */
} Errors;

/* Pairs of particles: all of them, or so many by chance. */
typedef struct PairSample {
  int count;
  int (*pairs)[2];
} PairSample;

/* False if there is no memory. */
bool pairSampleInit(PairSample* sample, int particleCount, Random* random);
void pairSampleFree(PairSample* sample);

/* Of a chain, one particle behind the other: 3 * particleCount coordinates, and where the particles should be. */
Errors errorsOf(const PairSample* sample, int particleCount, const double* positions, const Place* expected);

/* Twice the largest distance from the centroid. */
double sizeOf(int particleCount, const Place* places);

#endif /* ERRORS_H_ */
