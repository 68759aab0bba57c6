/* ctgrowth.h: conformations of a loop between two fixed ends, each grown independent of all others, with a weight.
 *
 * A loop is a path of joints (torsions) that begins and ends in the fixed part, with side chains hanging on the pieces
 * between the joints. Sets of joints are drawn from densities p. The target is the density
 *
 *     product over sets of p, times 1 / |J|, for loops that close and in which no pair clashes,
 *
 * per volume of all joints but six, the pivots; J is their determinant, as in closed windows. For uniform p it is the
 * density of loops whose joints are uniform under the condition that they close. Joints in no set keep their present
 * angles.
 *
 * A run grows a population of loops from both ends, set by set, side chains with the backbone that bears them. Each
 * member tries some draws of a set, and keeps one that does not clash, preferably one whose ends have a distance that
 * the remaining joints often bridge. Its weight is multiplied by the share of its draws that are free, and corrects the
 * preference. Members of low weight are replaced by copies of others (sequential Monte Carlo: Doucet, Johansen (2009);
 * Rosenbluth, Rosenbluth (1955)). In the middle the six pivots of three residues close each loop in all ways there are
 * as closed windows do, and one is drawn by its target density. One member is drawn from the final population, with the
 * run's estimate Z of the integral of the target as its weight. Then E[Z f] is the integral of f times the target, for
 * any f and any size of the population: weighted means over independent runs are means over the target. Larger
 * populations have more equal weights.
 *
 * Pairs clash if r_i + r_j - d is above the tolerance, plus the allowance where one may donate a hydrogen bond that the
 * other accepts; pairs of one piece, excluded pairs, and pairs of radius 0 do not.
 *
 * Lengths are in nm, angles in rad. A growth is never changed by runs, so threads can share it. */
#ifndef CT_GROWTH_H_
#define CT_GROWTH_H_

#include <stdbool.h>
#include <stdint.h>

#include "ctdensity.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ctGrowth ctGrowth;

/* Roles in hydrogen bonds: the bits may be combined. */
#define CT_GROWTH_DONOR 1
#define CT_GROWTH_ACCEPTOR 2

/* A loop. Piece 0 is all that is fixed. Joint j < pathCount lies on the path: it turns piece j + 1, and all pieces
 * towards the end, relative to piece j; behind the last joint of the path is piece 0 again. Joint p >= pathCount turns
 * piece p, of a side chain, relative to piece parents[p - pathCount], which is at least 1 and less than p. All
 * particles are given as they lie in one conformation that closes the loop. */
typedef struct ctGrowthDefinition {
  int pathCount;
  int jointCount;
  const double (*jointPositions)[4][3]; /* of each joint's four particles: it turns about the line from the second to
                                           the third, and its angle is their dihedral */
  const int* parents;                   /* jointCount - pathCount */
  int particleCount;                    /* that move */
  const double (*positions)[3];
  const double* radii;
  const uint8_t* roles;
  const int* pieces; /* of each particle, 1 to jointCount - 1 */
  int fixedCount;
  const double (*fixedPositions)[3];
  const double* fixedRadii;
  const uint8_t* fixedRoles;
  int exclusionCount; /* of pairs that move */
  const int (*exclusions)[2];
  int fixedExclusionCount; /* of pairs of a particle that moves, the first, and one that is fixed */
  const int (*fixedExclusions)[2];
  double tolerance;
  double allowance;
  int setCount;
  const int* setSizes; /* the number of joints of each set */
  const int*
      setJoints; /* the joints of all sets, one set after the other: of the path in a row, or of one side chain */
  const ctDensity* const* densities; /* one a set; they have to live as long as the growth */
} ctGrowthDefinition;

/* Prepares growth, in O(particles + fixed particles near the loop) and some tenths of a second. NULL if the definition
 * contradicts its comments, if there is no memory, or if the loop has no three sets of two joints whose axes meet, near
 * enough to each other to close it; *problem, if it is not NULL, then is a text that lives forever. */
ctGrowth* ctCreateGrowth(const ctGrowthDefinition* definition, const char** problem);

/* NULL is allowed. */
void ctDestroyGrowth(ctGrowth* growth);

/* A source of independent uniform numbers in [0, 1). */
typedef double ctUniformFunction(void* context);

/* How a run is made. */
typedef struct ctGrowthRun {
  int population;    /* at least 1 */
  int backboneDraws; /* of each set of the path, at least 1 */
  int sideDraws;     /* of each side chain, at least 1 */
  ctUniformFunction* uniform;
  void* context;
} ctGrowthRun;

/* Grows one loop. `positions` receives the positions of its particles, `angles` those of all joints, in [-pi, pi];
 * *logWeight the logarithm of Z, and *logDensity that of the product of p of all sets. The ends close to 1e-10 nm.
 * False if the population died out, which is a run of the weight 0, or if there is no memory; then *hasMemory is false.
 */
bool ctGrow(const ctGrowth* growth, const ctGrowthRun* run, double (*positions)[3], double* angles, double* logWeight,
            double* logDensity, bool* hasMemory);

#ifdef __cplusplus
}
#endif

#endif /* CT_GROWTH_H_ */
