/* chaintree.h: exact clash tests and cutoff pairs for molecules that move in torsion space.
 *
 * The method was published by Lotan, Schwarzer, Halperin and Latombe, "Efficient Maintenance and Self-Collision Testing
 * for Kinematic Chains" (2002), cited below by section. Lengths are in nm, angles in rad, energies in kJ/mol.
 *
 * The scene. Particles are spheres. A particle of radius 0 moves with its link but is not modelled: it is in no clash
 * and in no neighbour pair. Every particle belongs to a *link*, a rigid set of particles. Links form a forest: each has
 * a parent link or none, and a joint that places it. The *sequence* holds all links in one line, depth-first from the
 * world, so that a joint moves one interval of it. Over the sequence there is a balanced tree of bounding volumes. Each
 * of its nodes caches the *shortcut*, the product of the joints across it (section 2.1), and a volume in its parent's
 * frame (section 2.2).
 *
 * A trial is propose -> test -> accept or reject. Proposing and testing change nothing that a query can see. A rejected
 * trial leaves every bit as it was. An accepted trial updates O(k log N) nodes for k changes, each node at most once
 * (section 3.1).
 *
 * The state is the reference positions, since then the rotation angle of each torsion and the rotation of each ball
 * joint, and the placement of each free link. Transforms are a pure function of that state. So errors do not grow with
 * the number of moves, and a state reached by accepted trials has the same bits as the same state built from scratch.
 *
 * Flexible scenes. There a trial may also displace particles within their links. The reference position of such a
 * particle becomes its place in the frame that its link had at first. A torsion turns about the line between its two
 * axis particles wherever they are, and a ball joint about its particle. So the state of every joint is a placement:
 * the rotation of its link since the reference positions and the link's origin, in the parent's frame. Each turn rounds
 * them, by some 1e-16 of their size, so that errors grow about as in a random walk: distances at torsions of 0.15 nm
 * had drifted by 4e-13 nm after 1e8 trials of TestDrift.
 *
 * Closed windows. Torsions may turn so that what lies behind them stays where it is, up to rounding. A body that a
 * trial of two changes or more displaces by less than 2e-11 nm, roundings of the scene's size included, is merged with
 * what does not move, and one that moves as another body does, up to as much, with that one. Pairs within merged bodies
 * are neither tested nor listed, and their particles are not moved. The state itself is exact: only verdicts, and data
 * kept for clients that sum over leaves, have an error. Each accepted trial adds its skipped displacements to a bound
 * of that error. Before the bound reaches CT_SIGMA / 2, ctTestTrial checks all pairs of the state by their limits, and
 * the bound becomes the most that a pair is beyond its limit; kept positions are computed again. If that is too much,
 * because rounding has moved a pair beyond its limit in very many trials or the state was not made by trials without
 * clashes, then trials are tested in full, as if no bodies were merged, until such a check finds less. The engine never
 * changes a limit on its own.
 *
 * Exactness. With sigma = CT_SIGMA, every verdict and every listed pair agrees with exact arithmetic on the positions
 * wherever |overlap - limit| > sigma (|distance - cutoff| > sigma). Nearer than that, one canonical distance decides, a
 * pure function of the state.
 *
 * Errors. Calls that can fail return a ctStatus; ctGetErrorText names the culprit. A failed call changes nothing but
 * that text, a failed allocation included. There are no globals: handles in different threads are independent; one
 * handle serves one thread at a time. Callbacks must not call back into the handle that runs them.
 *
 * Arguments. A pointer may be NULL where its description says so, and where it would be to an array without elements.
 * Any other NULL, a handle included, makes a call that returns a status return ctInvalidArgument, and any other call do
 * nothing and return 0, false, NULL or an empty text. Counts outside of 0 to CT_MOST_COUNT are errors; an array has to
 * have as many elements as its count says. A handle that has been freed must not be used. */
#ifndef CHAINTREE_H_
#define CHAINTREE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Distances this close (nm) to a limit are decided by the canonical distance. */
#define CT_SIGMA 1e-9

/* Lengths (nm) that are not finite or beyond this are errors, since bounds are in single precision: coordinates,
 * radii, tolerances, probes, pivots and translations; and rotations by more rad. */
#define CT_MOST_LENGTH 1e15

/* Larger counts are errors, since some of their multiples have to be an int. */
#define CT_MOST_COUNT 536870911

/* No parent, no particle, no link. */
#define CT_NULL (-1)

/* An opaque handle: one scene and its state. */
typedef struct ctChainTree ctChainTree;

/* A set of particles of a scene. */
typedef struct ctSelection ctSelection;

typedef enum ctStatus {
  ctSuccess = 0,
  ctOutOfMemory,     /* nothing was changed; the handle stays usable */
  ctInvalidArgument, /* an argument is out of range, not finite, or contradicts another */
  ctNoTrial          /* the call needs an open trial and there is none */
} ctStatus;

/* Whether a particle can take part in a hydrogen bond; bits. */
typedef enum ctHydrogenBondRole {
  ctNoHydrogenBond = 0,
  ctDonor = 1,
  ctAcceptor = 2,
  ctDonorAndAcceptor = 3
} ctHydrogenBondRole;

/* How a link is placed relative to its parent. */
typedef enum ctJointKind {
  ctFixedJoint,   /* fixed in the world; only for a link without a parent */
  ctFreeJoint,    /* by any rigid transform; for a link with a parent or without */
  ctTorsionJoint, /* by a rotation about a bond between the link and its parent */
  ctBallJoint     /* by any rotation about a particle of the link or of its parent */
} ctJointKind;

/* x -> rotation * x + translation; rotation is row-major. */
typedef struct ctTransform {
  double rotation[9];
  double translation[3];
} ctTransform;

/* The description of a scene. All arrays are the caller's, who may free them once ctCreate has returned. */
typedef struct ctDefinition {
  int particleCount;
  const double* positions;          /* 3 * particleCount, nm: the reference positions */
  const double* radii;              /* particleCount, nm, >= 0; 0: not modelled */
  const uint8_t* hydrogenBondRoles; /* particleCount bits of ctHydrogenBondRole, or NULL: none */
  const int* particleLinks;         /* particleCount, the link of each particle */
  const uint8_t* listed;            /* particleCount flags, or NULL: none. A particle of radius 0 that is listed stands
                                       in a leaf like those with a radius, and is in no clash and no list all the same */

  int linkCount;
  const int* linkParents;       /* linkCount, index of the parent (any order, no cycles), or CT_NULL */
  const uint8_t* linkJoints;    /* linkCount values of ctJointKind */
  const int (*linkTorsions)[4]; /* linkCount; for a torsion joint p1-p2-p3-p4: of the axis particles p2 and p3, one lies
                                   in the link and the other in its parent. For a ball joint p2 is the particle about
                                   which it turns. Not read for other joints; NULL if none */

  int exclusionCount;
  const int (*exclusions)[2]; /* pairs that never clash and are in no list, either order; repeats are harmless */

  const double (*box)[3]; /* the three vectors of a periodic box, nm, reduced as OpenMM's are, or NULL: not periodic.
                             In a box every pair counts in all images, and an exclusion holds in all of them */

  double overlapTolerance;      /* nm, >= 0: overlap that every pair may have */
  double hydrogenBondAllowance; /* nm, >= 0: added where one particle may donate and the other accept */

  bool isFlexible; /* trials may displace particles within their links, see ctProposeDisplacements */
} ctDefinition;

/* The cost of a call. Calls add to the counts that they are given, up to INT64_MAX; NULL: no counts are wanted. */
typedef struct ctCounts {
  int64_t volumeTests;   /* pairs of bounding volumes compared */
  int64_t particleTests; /* pairs of particles whose distance was computed */
  int64_t nodesUpdated;  /* nodes of the tree recomputed, leaves included */
} ctCounts;

/* One change of a trial. */
typedef struct ctChange {
  int link;           /* with a joint that is not fixed */
  double angle;       /* torsion joint: added to the dihedral p1-p2-p3-p4, rad */
  double rotation[3]; /* free joint: rotation vector, world frame, rad, about pivot; ball joint: about its particle */
  double pivot[3];    /* free joint: nm, world frame */
  double translation[3]; /* free joint: nm, world frame, after the rotation */
} ctChange;

/* A particle that a trial displaces. */
typedef struct ctDisplacement {
  int particle;
  double shift[3]; /* nm, world frame */
} ctDisplacement;

/* Receives a pair with particle1 < particle2; return false to end the query. The order of pairs is not defined. */
typedef bool ctPairFunction(void* context, int particle1, int particle2, double value);

/* Receives a pair of an open trial with its distances before and in the trial, nm. */
typedef bool ctChangedPairFunction(void* context, int particle1, int particle2, double before, double after);

/* Receives a particle and its overlap with a probe, nm. */
typedef bool ctParticleFunction(void* context, int particle, double overlap);

/* ---- Life ---- */

/* Makes a scene: O(N log N) time, O(N) memory. On failure *tree is NULL and errorText (of errorSize bytes, may be NULL)
 * says why. Errors: what contradicts the comments of ctDefinition. */
ctStatus ctCreate(const ctDefinition* definition, ctChainTree** tree, char* errorText, size_t errorSize);

/* Frees a scene; NULL is ignored. */
void ctDestroy(ctChainTree* tree);

/* One sentence about the last call on this handle that failed; empty if none has. Valid until the next call. */
const char* ctGetErrorText(const ctChainTree* tree);

/* The instruction set that the scene's tests use: "avx512", "avx2" or "portable", the widest that the machine has.
 * Results have the same bits on each. The environment variable CHAINTREE_SIMD, set to one of these names when the scene
 * is made, selects it or, if the machine lacks it, a narrower one. Likewise CHAINTREE_TRIALS=tree,
 * =boxes (the tree, with oriented boxes at all visits) or =clearances makes the engine test all trials in that way,
 * instead of in the way that costs least. Other values have no effect. */
const char* ctGetInstructionSet(const ctChainTree* tree);

/* True if a definition has the particles, links and joints that the scene was made from, wherever particles are and
 * whatever their radii. O(N). */
bool ctHasStructure(const ctChainTree* tree, const ctDefinition* definition);

/* ---- State ---- */

/* Makes these 3 * particleCount coordinates (nm) the reference positions: from then on no torsion is turned and no free
 * link moved. Drops an open trial, keeps limits. O(N). Errors: a coordinate that is not finite, or beyond
 * CT_MOST_LENGTH.
 */
ctStatus ctSetPositions(ctChainTree* tree, const double* positions);

/* Sets the vectors of the periodic box, as in ctDefinition; NULL: none. Makes the positions of the state the reference
 * positions, as ctSetPositions does. O(N). Errors: vectors that are not reduced; a box that is narrower, between two
 * opposite faces, than twice the largest distance at which two particles may clash; no memory. */
ctStatus ctSetBox(ctChainTree* tree, const double (*box)[3]);

/* True if the scene is in a periodic box; writes its vectors then. */
bool ctGetBox(const ctChainTree* tree, double box[3][3]);

/* Multiplies the vectors of the periodic box by `factor`, and moves each molecule, that is a link with a free joint on
 * the world and all that hangs on it, as a rigid body, so that the coordinates of its centroid are multiplied, too.
 * Fixed particles stay. Reference positions keep their bits. Drops an open trial, keeps limits. O(N). Errors: no box; a
 * factor that is not positive and finite; a box that ctSetBox would refuse; no memory. */
ctStatus ctScaleBox(ctChainTree* tree, double factor);

/* Writes the 3 * particleCount coordinates (nm) of the state. Particles of a molecule in its reference state keep their
 * reference bits, fixed particles always. O(N). */
void ctGetPositions(ctChainTree* tree, double* positions);

/* The same for the open trial: the bits that ctGetPositions would give after ctAccept. */
ctStatus ctGetTrialPositions(ctChainTree* tree, double* positions);

/* The coordinates (nm) of `count` particles, three of each: the bits of ctGetPositions, or with `inTrial` the
 * bits of ctGetTrialPositions. O(count log N), in a trial of k changes O((count + k) log N). Errors: an index
 * or the count out of range; `inTrial` without an open trial. */
ctStatus ctGetPositionsOf(ctChainTree* tree, bool inTrial, int count, const int* particles, double* positions);

/* ctGetTrialPositions for an array that the caller keeps from trial to trial: writes only coordinates that may have
 * changed since the last call of this function, for an earlier trial. `isNewArray`: writes all of it. O(particles that
 * have moved since + N / 16), whatever was called in between. */
ctStatus ctFollowTrialPositions(ctChainTree* tree, bool isNewArray, double* positions);

/* The same for the state, in the same array: the bits of ctGetPositions. */
void ctFollowPositions(ctChainTree* tree, bool isNewArray, double* positions);

/* The state as numbers, to be stored and set again: the reference positions (3 * particleCount, nm); then for each
 * link, in the order of the definition, if it has a torsion joint the angle turned since then (rad, in [-pi, pi]), if a
 * ball joint its rotation since then in its parent's frame (unit quaternion w, x, y, z), if a free joint the same and
 * its origin in its parent's frame (nm); in a periodic box, if it has no parent, also by how many of each box vector
 * the engine has it shifted. In a flexible scene the reference positions are followed by the world's origin (nm), all
 * joints have the numbers of a free joint, and then the origin of the link in the reference positions (nm).
 * ctGetStateSize tells how many numbers there are. Limits and an open trial are not part of the state. O(N). */
size_t ctGetStateSize(const ctChainTree* tree);
void ctGetState(const ctChainTree* tree, double* state);

/* Makes numbers from ctGetState the state. Drops an open trial, keeps limits. If both scenes were made from the same
 * definition, every result has the same bits as in the scene from which the numbers were taken. If only the positions
 * in the definition differed, results agree up to rounding, since scenes are laid out by positions. O(N). Errors:
 * numbers that are no state of this scene, such as an angle of a torsion whose axis has no length. */
ctStatus ctSetState(ctChainTree* tree, const double* state);

/* Makes later results have the same bits as after ctSetState with the numbers of ctGetState: discards stored values
 * that have an error (see above, closed windows). O(1), and O(N) in the next call. */
void ctRenew(ctChainTree* tree);

/* The dihedral p1-p2-p3-p4 of a torsion joint in (-pi, pi], rad: its value in the reference positions plus the turns
 * since, or in a flexible scene its value in the present positions, in O(log N). Errors: link out of range; not a
 * torsion joint; a dihedral that is undefined because three of its particles are collinear. */
ctStatus ctGetTorsionAngle(ctChainTree* tree, int link, double* angle);

/* The centroid (nm) of all particles, modelled or not, of a link and the links that hang on it. O(log N).
 * Errors: link out of range; a link with a fixed joint, since all of these are part of the world. */
ctStatus ctGetCentroid(ctChainTree* tree, int link, double centroid[3]);

/* The transform from the frame of linkB to the frame of linkA, by shortcuts, in O(log N) (section 2.1). A link's frame
 * moves with it; in the reference positions its axes are the world's and its origin is the link's particle on the
 * torsion axis, the particle about which a ball joint turns, or for other joints its lowest-numbered particle. It stays
 * there when that particle is displaced. Errors: link out of range. */
ctStatus ctGetRelativeTransform(ctChainTree* tree, int linkA, int linkB, ctTransform* transform);

/* Writes the orientation of each link, in the order of the definition: the rotation (row-major) by which it is turned
 * against the reference positions. Between two states with the same reference positions, a link has turned by the
 * product of its later orientation and the inverse of the earlier one. O(links log N). */
void ctGetOrientations(ctChainTree* tree, double (*orientations)[9]);

/* ---- Limits of single pairs ---- */

/* The limit of a pair is its tolerance, unless it is set here. A trial clashes if an overlap is beyond its limit. */

/* Makes these limits (nm) the only ones. A limit not above its pair's tolerance is ignored; INFINITY allows any
 * overlap. Of several limits of a pair the largest counts. Errors: a particle or the count out of range; a particle
 * with itself; a limit that is NaN. */
ctStatus ctSetLimits(ctChainTree* tree, int count, const int (*pairs)[2], const double* limits);

/* Gives each pair whose overlap is beyond its limit a new one: its overlap now plus CT_SIGMA, so that rounding cannot
 * make its own state clash. *raised is the number of such pairs. */
ctStatus ctRaiseLimits(ctChainTree* tree, int* raised, ctCounts* counts);

/* *clash is true if some pair of the state overlaps beyond its limit: the test of ctTestTrial, for all pairs. If there
 * is a clash and pair is not NULL, pair holds one, lower index first. */
ctStatus ctTestState(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts);

/* The number of pairs with a limit of their own; and the first `capacity` of them, sorted, particle1 < particle2. A
 * negative capacity is none. */
int ctGetLimitCount(const ctChainTree* tree);
void ctGetLimits(const ctChainTree* tree, int capacity, int (*pairs)[2], double* limits);

/* ---- Trials ---- */

/* Proposes a trial of these changes, each of another link, and rejects an open one. Writes nothing that a query can
 * see. Errors: count or link out of range, a link named twice, a fixed joint, a torsion whose axis has no length, a
 * value that is not finite or beyond CT_MOST_LENGTH, a motion that takes a link ten times as far away. O(k log N). */
ctStatus ctPropose(ctChainTree* tree, int count, const ctChange* changes);

/* Proposes a trial that displaces these particles, each once, while all others stay, and rejects an open one. Particles
 * of one shift are one body. Writes nothing that a query can see. Errors: the scene is not flexible; the count or a
 * particle out of range; a particle named twice; a fixed particle; a shift that is not finite or beyond CT_MOST_LENGTH,
 * or may take the particle farther than that; no memory. O(k log k), with d different shifts O(k (log k + d)). */
ctStatus ctProposeDisplacements(ctChainTree* tree, int count, const ctDisplacement* displacements);

/* *clash is true if some pair overlaps beyond its limit in the open trial. Pairs that the trial moves as one rigid body
 * are skipped (section 2.3); so are those within merged bodies (see above, closed windows). If there is a clash and
 * pair is not NULL, pair holds one, lower index first. */
ctStatus ctTestTrial(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts);

/* Calls function for each pair whose distance the open trial changes, by more than the roundings of closed windows, and
 * that is within cutoff (nm, > 0 and finite) before the trial or in it. */
ctStatus ctForEachChangedPair(ctChainTree* tree, double cutoff, ctChangedPairFunction* function, void* context,
                              ctCounts* counts);

/* Makes the open trial the state, whether it was tested or clashes or not. */
ctStatus ctAccept(ctChainTree* tree, ctCounts* counts);

/* Ends the open trial, if there is one. The state keeps every bit. */
void ctReject(ctChainTree* tree);

/* nm: the sum over all accepted trials of how far each may have displaced particles of merged bodies, which bounds the
 * error of a client's stored results for their pairs. */
double ctGetTotalShift(const ctChainTree* tree);

/* True if a trial is open: proposed, and neither accepted nor rejected. */
bool ctHasTrial(const ctChainTree* tree);

/* How many trials have been proposed, how many of them were accepted, and how often the state has changed, by that or
 * otherwise: clients distinguish trials and states by these. */
int64_t ctGetTrialCount(const ctChainTree* tree);
int64_t ctGetAcceptedCount(const ctChainTree* tree);
int64_t ctGetChangeCount(const ctChainTree* tree);

/* ---- Leaves: for clients that sum something over pairs of particles ---- */

/* The tree's lowest nodes are leaves: CT_LEAF_WIDTH consecutive slots of the sequence, each of which holds a particle
 * or none. Particles with a radius, and those listed in the definition, have a slot. A client stores its data
 * of particles in columns in this order, and its results for pairs of leaves. */
#define CT_LEAF_WIDTH 16

/* Positions (nm, world) of the particles of a leaf; 0 where a slot holds none. */
typedef struct ctLeafPositions {
  double x[CT_LEAF_WIDTH];
  double y[CT_LEAF_WIDTH];
  double z[CT_LEAF_WIDTH];
} ctLeafPositions;

/* Consecutive slots, up to the next piece's, that an open trial moves as one rigid body. All pieces with one number are
 * one body, and body 0 is not moved; both up to merged bodies. */
typedef struct ctPiece {
  int slotBegin;
  int body;
} ctPiece;

/* In a periodic box a molecule may reach over this many of each box vector. */
#define CT_MOST_IMAGE 2047

/* A pair of leaves a <= b of which some particles move relative to each other in the open trial. In a periodic box it
 * is a pair of one image of a with b; of a leaf with itself only one of two opposite images is listed. */
typedef struct ctLeafPair {
  int a;
  int b;
  float squaredGap; /* of boxes around their particles: the least before the trial and in it, nm^2; 0 for a leaf with
                       itself, unless it is an image */
  int image[3];     /* the numbers of box vectors by which a is shifted */
} ctLeafPair;

/* The number of leaves, and the particle in each of their CT_LEAF_WIDTH slots; CT_NULL: none. */
int ctGetLeafCount(const ctChainTree* tree);
void ctGetLeafParticles(const ctChainTree* tree, int* particles);

/* The positions of all leaves in the state. They equal ctGetPositions up to rounding and, for merged bodies, CT_SIGMA /
 * 2; after ctRenew up to rounding alone. In a periodic box each molecule, that is a link with a free joint on the world
 * and all that hangs on it, is shifted as a whole by some box vectors. The array belongs to the scene and is up to date
 * until the state changes. O(leaves that have moved since the last call). NULL if there is no memory. */
const ctLeafPositions* ctGetLeaves(ctChainTree* tree);

/* By how much (nm) the molecule of a link is shifted there, or in the open trial. 0 without a box, and for molecules
 * that are not shifted. O(log molecules + changes). */
void ctGetMoleculeShift(const ctChainTree* tree, int link, bool inTrial, double shift[3]);

/* The pieces of the open trial, ascending, and the motion of each body in the world: in the trial a particle of body b
 * is where motions[b] takes its position in the state. And the caller's links that the trial changes, in the order of
 * the sequence. The arrays belong to the scene, and stay until the trial ends. Without a trial there are none. O(k). */
int ctGetTrialPieces(ctChainTree* tree, const ctPiece** pieces, const ctTransform** motions);
int ctGetTrialLinks(ctChainTree* tree, const int** links);

/* The particles that the open trial displaces within their links, in the order of the sequence. The array belongs to
 * the scene, and stays until the trial ends. O(1). */
int ctGetTrialParticles(const ctChainTree* tree, const int** particles);

/* The pairs of leaves of which the open trial moves some particles relative to each other, and whose boxes are at most
 * cutoff (nm, > 0, may be INFINITY) apart before the trial or in it: each once, in an order that depends only on
 * the trial and the state. No two particles within the cutoff are lost to rounding: boxes are a little larger than
 * their particles need, by less than 1e-6 of their distance from the middle of the reference positions, in images by
 * less than 1e-5 of the scene's size. And the positions in the trial of all leaves, by the motions of ctGetTrialPieces;
 * only those of leaves in these pairs are right. The arrays belong to the scene, and stay until the next call or the
 * end of the trial. In a periodic box there is a pair for each image that is near, also of leaves of one body that
 * turns. For a turned side chain O(log N + pairs), otherwise up to O(N + pairs). Errors: no trial; a cutoff that is not
 * positive or, in a periodic box, is more than half its width; a molecule that reaches over more than CT_MOST_IMAGE
 * boxes; no memory. */
ctStatus ctGetChangedLeafPairs(ctChainTree* tree, double cutoff, size_t* count, const ctLeafPair** pairs,
                               const ctLeafPositions** positions, ctCounts* counts);

/* The same of the state: all pairs of leaves whose boxes are at most cutoff apart, each leaf with itself too. A leaf
 * without particles is in no pair, here and there. The array stays until the next call of this function. */
ctStatus ctGetLeafPairs(ctChainTree* tree, double cutoff, size_t* count, const ctLeafPair** pairs, ctCounts* counts);

/* ---- Selections ---- */

/* Makes a set of particles (any order, repeats are harmless) for queries of this scene in any state. On failure
 * *selection is NULL. O(N / 16 + count). Errors: an index out of range. */
ctStatus ctSelect(ctChainTree* tree, int count, const int* particles, ctSelection** selection);

/* Frees a selection, before its scene or after; NULL is ignored. */
void ctFreeSelection(ctSelection* selection);

/* ---- Queries of the state: every pair of modelled particles that is not excluded ---- */

/* *clash tells whether some pair overlaps by more than its tolerance (limits of single pairs are not used). If so and
 * pair is not NULL, pair holds one. */
ctStatus ctHasClash(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts);

/* Calls function(particle1, particle2, overlap in nm) for each pair that overlaps by more than its tolerance. */
ctStatus ctForEachClash(ctChainTree* tree, ctPairFunction* function, void* context, ctCounts* counts);

/* Calls function(particle1, particle2, distance in nm) for each pair at most cutoff (nm, > 0 and finite) apart, centre
 * to centre (section 6.3). */
ctStatus ctForEachNeighborPair(ctChainTree* tree, double cutoff, ctPairFunction* function, void* context,
                               ctCounts* counts);

/* The same pairs into arrays: `capacity` of them, particles1[i] < particles2[i], and, if distances is not NULL, how far
 * apart they are (nm). *count is how many there are; if they all fit and `sorted`, they ascend. */
ctStatus ctGetNeighborPairs(ctChainTree* tree, double cutoff, bool sorted, size_t capacity, int* particles1,
                            int* particles2, double* distances, size_t* count, ctCounts* counts);

/* Calls function(particle, overlap in nm) for each modelled particle that overlaps a sphere (nm) by more than the
 * overlap tolerance (section 6.3). Errors: a coordinate beyond CT_MOST_LENGTH; a radius that is not from 0 to that. */
ctStatus ctForEachClashWith(ctChainTree* tree, const double position[3], double radius, ctParticleFunction* function,
                            void* context, ctCounts* counts);

/* The least distance (nm), centre to centre, between a particle of one selection and a different particle of the other,
 * and the pair, in this order; excluded pairs and radius 0 included. Of pairs equally near it is the lowest, by its
 * first particle, then its second. Selections remember their nearest pair, whose present distance bounds the next
 * search: keep selections, since a query costs least if little has moved since the last one. Errors: there is no such
 * pair; a selection of another scene. */
ctStatus ctGetMinimumDistance(ctChainTree* tree, ctSelection* selection1, ctSelection* selection2, double* distance,
                              int pair[2], ctCounts* counts);

/* E = 1/2 k sum (overlap - tolerance)^2 over clashes, and if forces (3 * particleCount) is not NULL *adds* -dE/dx to it
 * (kJ/mol/nm; coincident particles are pushed apart along x, the lower index to +x). k in kJ/mol/nm^2, of any sign.
 * Errors: k that is not finite. */
ctStatus ctComputeEnergy(ctChainTree* tree, double k, double* energy, double* forces, ctCounts* counts);

/* ---- For tests ---- */

/* Recomputes transforms and bounds by brute force and compares. True if every cached value has the bits that the state
 * implies, every volume holds the particles below it, and no pair has less clearance than is kept for it. O(N^2). */
bool ctValidate(ctChainTree* tree);

#ifdef __cplusplus
}
#endif

#endif /* CHAINTREE_H_ */
