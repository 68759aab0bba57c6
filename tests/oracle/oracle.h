/* oracle.h: the engine's answers, computed in the simplest way.
 *
 * A scene of spheres in rigid links, in long double, where every answer comes from comparing all pairs. It shares no
 * code and no header with the engine, so an error would have to be made twice to go unnoticed. Definitions, sizes and
 * units are those of chaintree.h (nm, rad, kJ/mol).
 *
 * Arguments are flat arrays, so that C, C++ and Python's ctypes can call it. A list function returns the number of
 * entries and writes the first `capacity` of them, sorted, particle1 < particle2.
 *
 * Answers near a limit. A list is requested with some slack and gives each entry's margin (its distance beyond the
 * limit; negative: within it), so that the caller can accept either answer if the margin is negligible.
 *
 * The oracle checks no arguments: callers pass only input that the engine has accepted. Without memory it aborts.
 */
#ifndef ORACLE_H_
#define ORACLE_H_

#ifdef __cplusplus
extern "C" {
#endif

/* Joint kinds of a link, and bits of hydrogen bond roles: the numbers that chaintree.h gives them. */
enum { ORACLE_FIXED = 0, ORACLE_FREE = 1, ORACLE_TORSION = 2, ORACLE_BALL = 3 };
enum { ORACLE_DONOR = 1, ORACLE_ACCEPTOR = 2 };

/* Doubles that describe one change: angle, rotation vector, pivot, translation. A ball joint has a rotation alone. */
enum { ORACLE_CHANGE_SIZE = 10 };

/* Which positions a function is to look at. */
enum { ORACLE_STATE = 0, ORACLE_TRIAL = 1 };

typedef struct oracleScene oracleScene;

/* ---- Life ---- */

/* positions: 3 * particleCount; roles: particleCount, or NULL; linkTorsions: 4 * linkCount, or NULL;
 * exclusions: 2 * exclusionCount. Everything is copied. */
oracleScene* oracleCreate(int particleCount, const double* positions, const double* radii, const unsigned char* roles,
                          const int* particleLinks, int linkCount, const int* linkParents,
                          const unsigned char* linkJoints, const int* linkTorsions, int exclusionCount,
                          const int* exclusions, double overlapTolerance, double hydrogenBondAllowance);
void oracleDestroy(oracleScene* scene);

/* From now on particles may be displaced within their links. Links turn about the places of particles in the state. */
void oracleMakeFlexible(oracleScene* scene);

/* ---- State ---- */

/* New reference positions; ends a trial, keeps limits. */
void oracleSetPositions(oracleScene* scene, const double* positions);
void oracleGetPositions(const oracleScene* scene, int which, double* positions);

/* The dihedral of any four particles, by the IUPAC sign. *sine is the smaller sine of its two bond angles: near 0 it is
 * undefined. */
double oracleDihedral(const oracleScene* scene, int which, int p1, int p2, int p3, int p4, double* sine);

/* The dihedral of a torsion joint: that of the reference positions plus all turns since; in a flexible scene that of
 * the state. */
double oracleTorsionAngle(const oracleScene* scene, int link, double* sine);

/* The mean position of the particles of a link and of all links that hang on it. Returns their number. */
int oracleCentroid(const oracleScene* scene, int link, double* centroid);

/* Writes the rotation (row-major) by which a link is turned since the reference positions. */
void oracleOrientation(const oracleScene* scene, int link, double* rotation);

/* Writes the rotation (row-major) and translation from linkB's frame to linkA's. */
void oracleRelativeTransform(const oracleScene* scene, int linkA, int linkB, double* rotation, double* translation);

/* ---- Limits of single pairs ---- */

/* Makes these the only limits; those not above their pair's tolerance are passed over. */
void oracleSetLimits(oracleScene* scene, int count, const int* pairs, const double* limits);

/* ---- Trials ---- */

/* Opens a trial: links[i] by changes[ORACLE_CHANGE_SIZE * i ...]. */
void oraclePropose(oracleScene* scene, int count, const int* links, const double* changes);

/* Opens a trial: particles[i] by shifts[3 * i ...]. Particles of one shift, bit by bit, are one body. */
void oracleProposeDisplacements(oracleScene* scene, int count, const int* particles, const double* shifts);

/* The margin (overlap - limit) of the worst pair that the trial does not move as one rigid body, and that pair;
 * -infinity without a pair that touches. The trial is refused if the margin is positive. */
double oracleWorstTrialMargin(const oracleScene* scene, int* pair);

/* Whether the trial moves the two particles differently. */
int oracleIsPairChanged(const oracleScene* scene, int particle1, int particle2);

/* Pairs that the trial changes with a distance at most cutoff before it or in it. */
int oracleListChangedPairs(const oracleScene* scene, double cutoff, int capacity, int* pairs, double* before,
                           double* after);

void oracleAccept(oracleScene* scene);
void oracleReject(oracleScene* scene);

/* ---- Pairs ---- */

double oracleDistance(const oracleScene* scene, int which, int particle1, int particle2);

/* overlap - tolerance, and overlap - limit; -infinity for pairs that cannot clash. */
double oracleClashMargin(const oracleScene* scene, int which, int particle1, int particle2);
double oracleLimitMargin(const oracleScene* scene, int which, int particle1, int particle2);

/* ---- Queries of the state ---- */

/* Pairs with overlap > tolerance - slack. */
int oracleListClashes(const oracleScene* scene, double slack, int capacity, int* pairs, double* overlaps,
                      double* margins);

/* Pairs with overlap > limit - slack. */
int oracleListBeyondLimits(const oracleScene* scene, double slack, int capacity, int* pairs, double* overlaps,
                           double* margins);

/* Pairs at most cutoff apart. */
int oracleListNeighborPairs(const oracleScene* scene, double cutoff, int capacity, int* pairs, double* distances);

/* Particles whose overlap with a sphere is greater than the overlap tolerance - slack. */
int oracleListClashesWith(const oracleScene* scene, const double* position, double radius, double slack, int capacity,
                          int* particles, double* overlaps, double* margins);

/* The least distance between a particle of one set and another one of the other set; infinity if there is none. */
double oracleMinimumDistance(const oracleScene* scene, int count1, const int* particles1, int count2,
                             const int* particles2);

/* Returns the energy; forces (3 * particleCount, may be NULL) are overwritten. */
double oracleEnergy(const oracleScene* scene, double k, double* forces);

#ifdef __cplusplus
}
#endif

#endif /* ORACLE_H_ */
