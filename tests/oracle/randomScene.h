/* randomScene.h: scenes of every shape that an engine may meet, from a seed.
 *
 * Chains, branched trees and stars; one molecule or many, fixed, free or both; links of one particle or of hundreds;
 * walks, crowds, lattices (full of exact ties), lines and planes (full of collinear particles), near the origin and far
 * from it.
 */
#ifndef RANDOM_SCENE_H_
#define RANDOM_SCENE_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct randomSource {
    uint64_t state;
} randomSource;

randomSource randomSourceFromSeed(uint64_t seed);

/* An integer from 0 to count - 1. */
int randomInt(randomSource* random, int count);

/* A number from low to high. */
double randomReal(randomSource* random, double low, double high);

int randomChance(randomSource* random, double probability);

/* Writes a direction, uniform on the unit sphere. */
void randomDirection(randomSource* random, double direction[3]);

/* The arrays of oracleCreate. */
typedef struct randomScene {
    int particleCount;
    double* positions;
    double* radii;
    unsigned char* roles; /* or NULL */
    int* particleLinks;
    int linkCount;
    int* linkParents;
    unsigned char* linkJoints;
    int* linkTorsions;
    int exclusionCount;
    int* exclusions;
    double overlapTolerance, hydrogenBondAllowance;
    double extent; /* nm: no particle is farther than this from the first one */
} randomScene;

void randomSceneCreate(randomScene* scene, randomSource* random);
void randomSceneDestroy(randomScene* scene);

#ifdef __cplusplus
}
#endif

#endif /* RANDOM_SCENE_H_ */
