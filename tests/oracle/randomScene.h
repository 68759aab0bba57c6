/* randomScene.h: scenes of every shape that an engine may meet, by random choices.
 *
 * Chains, branched trees and stars; one molecule or many, fixed, free or both; links of one particle or of hundreds;
 * walks, crowds, lattices (full of exact ties), lines and planes (full of collinear particles), near the origin and far
 * from it.
 */
#ifndef RANDOM_SCENE_H_
#define RANDOM_SCENE_H_

#include "randomSource.h"

#ifdef __cplusplus
extern "C" {
#endif

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
    double extent;  /* nm: no particle is farther than this from the first one */
    int isFlexible; /* particles may be displaced within their links */
} randomScene;

void randomSceneCreate(randomScene* scene, randomSource* random);
void randomSceneDestroy(randomScene* scene);

#ifdef __cplusplus
}
#endif

#endif /* RANDOM_SCENE_H_ */
