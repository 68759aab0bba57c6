/* ctenergy.h: energies of trials, computed from what a trial changes.
 *
 * An energy belongs to a scene of chaintree.h and follows its state. It has two parts. *Terms* are functions of a few
 * particles: bonds, angles, torsions, any expression. *Pairs* are Lennard-Jones and Coulomb, of all pairs of particles
 * that are not excluded. Beside them, energies of *values* are computed as a whole at each call. Lengths
 * are in nm, angles in rad, energies in kJ/mol, charges in elementary charges.
 *
 * What is stored. The value of each term, and for each pair of near leaves (see chaintree.h) the sum over its pairs of
 * particles. The energy is the sum of these values, so it does not drift: each value belongs to the positions from
 * which it was computed. A trial computes new values beside the stored ones, which they replace if the trial is
 * accepted.
 *
 * What a trial changes. A term changes only if a torsion between its particles turns and changes their distances: a
 * bond or an angle across the torsion's own bond never changes. A trial that displaces
 * particles changes all terms that hold one of them. A pair of leaves changes unless both lie in one rigid body of the
 * trial.
 *
 * Values of bodies that count as unmoved (see chaintree.h, closed windows) do not change. The positions to which stored
 * values belong are off by at most CT_MOST_LAG: before they are off by more, ctAcceptEnergyChange refreshes all values.
 *
 * Accuracy. Terms are in double. Pairs are in single precision, from coordinates relative to the leaves, and summed in
 * double: about 1e-6 kJ/mol a pair. Results have the same bits on each instruction set. With another C
 * library, only results that use its functions may differ: expressions (exp, log, sin and others), torsions (the cosine
 * of the phase) and Ewald summation (erf).
 *
 * Periodic boxes. In a scene with a box, pairs count in the image that is within the cutoff, which is at most half the
 * box's width. Terms use the positions as they are, or nearest images (ctTermSet.isPeriodic): each difference of
 * positions is reduced as OpenMM does. Absolute positions are the callers', without the shifts of molecules (see
 * ctGetLeaves). Refreshing the energy in a box that is too narrow for a cutoff is an error.
 *
 * Errors and arguments. As in chaintree.h; what has no value is NaN. One scene can have one energy or more; handles of
 * one scene serve one thread at a time. The scene has to outlive them.
 */
#ifndef CTENERGY_H_
#define CTENERGY_H_

#include "chaintree.h"

#ifdef __cplusplus
extern "C" {
#endif

/* nm. A body on which others have a net force of 1e4 kJ/mol/nm changes the energy by 1e-5 kJ/mol. */
#define CT_MOST_LAG CT_SIGMA

/* 1 / (4 pi epsilon0), kJ nm / (mol e^2), as OpenMM has it. */
#define CT_COULOMB 138.93545764438198

/* The most that alpha of Ewald summation times the cutoff can be: erfc is 2e-17 there. */
#define CT_MOST_EWALD 6.0

/* The most operations of an expression. */
#define CT_MOST_OPERATIONS 65536

/* An opaque handle: the energy of one scene. */
typedef struct ctEnergy ctEnergy;

/* Lennard-Jones and Coulomb between all particles: 4 epsilon ((sigma / r)^12 - (sigma / r)^6) + CT_COULOMB q1 q2 / r,
 * with sigma the mean of both particles' and epsilon the root of their product. With a cutoff, Coulomb becomes a
 * reaction field, CT_COULOMB q1 q2 (1 / r + k r^2 - c), k = (d - 1) / ((2 d + 1) cutoff^3), c = 3 d / ((2 d + 1)
 * cutoff), d the dielectric. With an ewaldAlpha it is CT_COULOMB q1 q2 erfc(ewaldAlpha r) / r, the direct space of
 * Ewald summation without its correction for excluded pairs. From the switching distance s to the cutoff,
 * Lennard-Jones is multiplied by 1 - 10 t^3 + 15 t^4 - 6 t^5, t = (r - s) / (cutoff - s). All numbers are finite,
 * except a cutoff of INFINITY. */
typedef struct ctNonbonded {
  const double* charges;    /* one a particle */
  const double* sigmas;     /* one a particle, nm */
  const double* epsilons;   /* one a particle, kJ/mol, >= 0 */
  double cutoff;            /* nm, > 0; INFINITY: none, and the next two are not read */
  double switchingDistance; /* nm, >= 0; not below the cutoff, or INFINITY: no switch */
  double dielectric;        /* k and c have to be finite; not read with an ewaldAlpha */
  int exclusionCount;
  const int (*exclusions)[2]; /* pairs that have no part in this, either order; repeats are harmless */
  double ewaldAlpha;          /* 1/nm, at most CT_MOST_EWALD / cutoff; 0: none. Not with born */
} ctNonbonded;

/* Kinds of terms, with their particles and parameters. Parameters are finite, except in expressions. */
typedef enum ctTermKind {
  ctHarmonicBondTerm,      /* 2; length, k: 1/2 k (r - length)^2 */
  ctHarmonicAngleTerm,     /* 3; angle, k: 1/2 k (theta - angle)^2 */
  ctPeriodicTorsionTerm,   /* 4; periodicity n (a whole number, >= 0), phase, k: k (1 + cos(n phi - phase)) */
  ctRyckaertBellemansTerm, /* 4; c0 ... c5: sum of ci cos(phi - pi)^i */
  ctTorsionMapTerm,        /* 8; map: a function of the dihedrals of the first four and of the last four */
  ctExceptionTerm,         /* 2; product of charges, sigma, epsilon: Lennard-Jones and Coulomb, without cutoff */
  ctExpressionTerm,        /* any; any: see ctExpression */
  ctCentroidTerm           /* groups; any, then the weight of each particle: an expression of the groups' centroids */
} ctTermKind;

/* A periodic function of two angles, each from 0 to 2 pi in `size` steps, by bicubic patches: in patch (s, t), with
 * u and v in [0, 1] from its lower corner, it is the sum over i, j < 4 of coefficients[16 (s + size t) + 4 i + j] u^i
 * v^j, where s and u belong to the first angle. */
typedef struct ctTorsionMap {
  int size;                   /* 1 or more */
  const double* coefficients; /* 16 * size * size, at most CT_MOST_COUNT */
} ctTorsionMap;

/* An input of an expression: something measured of the particles of its term. */
typedef enum ctMeasure {
  ctMeasureX, /* of one particle, nm */
  ctMeasureY,
  ctMeasureZ,
  ctMeasureDistance, /* of two, nm */
  ctMeasureAngle,    /* of three, in [0, pi] */
  ctMeasureDihedral  /* of four, in [-pi, pi] */
} ctMeasure;

typedef struct ctInput {
  ctMeasure measure;
  int particles[4]; /* one to four of them, by the measure; 0: the term's first particle */
} ctInput;

/* F(name, count, value) for each operator that computes `value` from the results a, b, c of `count` earlier operations
 * and from its own constant v. A minimum or maximum is a if either is NaN, as in OpenMM. constantPower(a, v) is a^v, by
 * repeated multiplication if v is a whole number. */
/* clang-format off */
#define CT_OPERATORS(F)                    \
  F(Add, 2, a + b)                         \
  F(Subtract, 2, a - b)                    \
  F(Multiply, 2, a * b)                    \
  F(Divide, 2, a / b)                      \
  F(Power, 2, pow(a, b))                   \
  F(Negate, 1, -a)                         \
  F(Sqrt, 1, sqrt(a))                      \
  F(Exp, 1, exp(a))                        \
  F(Log, 1, log(a))                        \
  F(Sin, 1, sin(a))                        \
  F(Cos, 1, cos(a))                        \
  F(Sec, 1, 1 / cos(a))                    \
  F(Csc, 1, 1 / sin(a))                    \
  F(Tan, 1, tan(a))                        \
  F(Cot, 1, 1 / tan(a))                    \
  F(Asin, 1, asin(a))                      \
  F(Acos, 1, acos(a))                      \
  F(Atan, 1, atan(a))                      \
  F(Atan2, 2, atan2(a, b))                 \
  F(Sinh, 1, sinh(a))                      \
  F(Cosh, 1, cosh(a))                      \
  F(Tanh, 1, tanh(a))                      \
  F(Erf, 1, erf(a))                        \
  F(Erfc, 1, erfc(a))                      \
  F(Step, 1, a >= 0 ? 1 : 0)               \
  F(Delta, 1, a == 0 ? 1 : 0)              \
  F(Square, 1, a * a)                      \
  F(Cube, 1, a * a * a)                    \
  F(Reciprocal, 1, 1 / a)                  \
  F(AddConstant, 1, a + v)                 \
  F(MultiplyConstant, 1, a * v)            \
  F(PowerConstant, 1, constantPower(a, v)) \
  F(Min, 2, b < a ? b : a)                 \
  F(Max, 2, a < b ? b : a)                 \
  F(Abs, 1, fabs(a))                       \
  F(Floor, 1, floor(a))                    \
  F(Ceil, 1, ceil(a))                      \
  F(Select, 3, a != 0 ? b : c)

#define CT_ENUMERATOR(name, count, value) ct##name##Operator,
typedef enum ctOperator {
  ctConstantOperator,    /* v */
  ctInputOperator,       /* input number a */
  ctParameterOperator,   /* the term's parameter number a */
  CT_OPERATORS(CT_ENUMERATOR)
  ctImageLengthOperator, /* of terms alone: the length of the difference (a, b, c) of positions, nm. With isPeriodic in
                            a periodic box, of the nearest image */
  ctTableOperator        /* not of terms: table number v of a, of a and b, or of a, b and c, by its dimensions */
} ctOperator;
#undef CT_ENUMERATOR
/* clang-format on */

typedef struct ctOperation {
  ctOperator kind;
  int arguments[3]; /* numbers of earlier operations; of an input; of a parameter */
  double constant;
} ctOperation;

/* An expression: the result of its last operation. Constants and parameters may be infinite or NaN. */
typedef struct ctExpression {
  int inputCount;
  const ctInput* inputs;
  int operationCount; /* 1 to CT_MOST_OPERATIONS */
  const ctOperation* operations;
} ctExpression;

/* Terms of one kind. */
typedef struct ctTermSet {
  ctTermKind kind;
  int count;
  int particlesPerTerm;
  const int* particles; /* count * particlesPerTerm, at most CT_MOST_COUNT; the same holds for parameters */
  int parametersPerTerm;
  const double* parameters; /* count * parametersPerTerm */
  int mapCount;             /* of maps, for ctTorsionMapTerm */
  const ctTorsionMap* maps;
  const ctExpression* expression; /* for ctExpressionTerm and ctCentroidTerm */
  int groupsPerTerm;              /* for ctCentroidTerm: groups of the same number of consecutive particles, whose
                                   * weighted means are the particles of the expression */
  bool isPeriodic;                /* in a periodic box, distances, angles and dihedrals are of nearest images */
} ctTermSet;

/* A function of one to three numbers by a table. A discrete one has a value for each whole number from 0, or for each
 * two or three, the first fastest; numbers are rounded, and NaN is what is outside. One that is not discrete has
 * pieces: of the range of each number, `sizes` equal intervals. In an interval of one number the function is the sum
 * over i of values[4 s + i] u^i, u in [0, 1] from its lower end; of two, as in ctTorsionMap. Outside of the range it is
 * 0, unless it is periodic. A table has at most CT_MOST_COUNT values, which may be anything. */
typedef struct ctTable {
  bool isDiscrete;
  bool isPeriodic;
  int dimensions;   /* 1 to 3; 1 or 2 if not discrete */
  int sizes[3];     /* 1 or more */
  double minima[3]; /* of the range, if not discrete: finite, and so is its width, below the maxima */
  double maxima[3];
  const double* values;
} ctTable;

/* The particles of one set interact with the particles of another. A pair that occurs in both orders counts once. */
typedef struct ctInteractionGroup {
  int counts[2];
  const int* particles[2];
} ctInteractionGroup;

/* An expression of the distance and the parameters of two particles, which has to be the same in either order, summed
 * over pairs of particles. Of its operations, input 0 is the distance in nm; parameter p < parametersPerParticle
 * belongs to one particle, and parametersPerParticle + p to the other. From the switching distance s to the cutoff it
 * is multiplied as Lennard-Jones is in ctNonbonded. It is computed in single precision, with an error of some units in
 * the last place of each operation, by functions of our own. Where that is not finite, or some number is beyond floats,
 * or an angle beyond 2^20 rad, it is computed in double by the C library's functions. Parts that depend on one particle
 * alone are computed once, and cost nothing. */
typedef struct ctPairSet {
  int operationCount; /* 1 to CT_MOST_OPERATIONS */
  const ctOperation* operations;
  int tableCount;
  const ctTable* tables;
  int parametersPerParticle; /* parameters of all particles together: at most CT_MOST_COUNT */
  const double* parameters;  /* one particle after another, finite */
  double cutoff;             /* nm, > 0; INFINITY: none */
  double switchingDistance;  /* nm; not below the cutoff: no switch; not read without one */
  int exclusionCount;
  const int (*exclusions)[2];
  int groupCount; /* 0: all pairs count; else the pairs of each group, once a group */
  const ctInteractionGroup* groups;
} ctPairSet;

/* Generalized Born solvation. Particle i has the Born sum I_i = sum over j != i of v(r; o_i, s_j) + neckScale n_ij(r),
 *   v(r; o, s) = 0 if r + s < o; else 1/2 (1/L - 1/U + 1/4 (r - s^2 / r) (1/U^2 - 1/L^2) + 1/2 log(L / U) / r),
 *     U = r + s, L = max(o, |r - s|), and 1/o - 1/L more where o < s - r if spheres within others are filled,
 *   n_ij(r) = m / (1 + 100 (r - d)^2 + 0.3e6 (r - d)^6) if r <= R_i + R_j + neckCut, else 0, where m and d have the
 *     index neckTypes[i] + neckTypeCount * neckTypes[j],
 * and the Born radius B_i = 1 / (1/o_i - tanh(alpha p - beta p^2 + gamma p^3) / R_i), p = I_i o_i, or without rescaling
 * 1 / (1/o_i - I_i). Here o is the offset radius, s the scaled one, R the whole one. The energy is the sum over i of
 *   -1/2 coulomb (1/soluteDielectric - exp(-kappa B_i) / solventDielectric) q_i^2 / B_i
 *     + surfaceEnergy (R_i + probeRadius)^2 (R_i / B_i)^6,
 * and the sum over all pairs i < j, excluded or not, of
 *   -coulomb (1/soluteDielectric - exp(-kappa f) / solventDielectric) q_i q_j (1/f - shift),
 *     f = sqrt(r^2 + B_i B_j exp(-r^2 / (4 B_i B_j))).
 * With a cutoff, pairs that are farther apart count in no sum. All numbers are finite, except a cutoff of
 * INFINITY. */
typedef struct ctBorn {
  const double* charges;     /* one a particle, as all arrays up to neckTypes */
  const double* radii;       /* nm, > 0 */
  const double* offsetRadii; /* nm, > 0 */
  const double* scaledRadii; /* may be negative */
  bool isFilled;             /* spheres within others are */
  bool isRescaled;
  const double* alphas; /* these three only if rescaled */
  const double* betas;
  const double* gammas;
  int neckTypeCount; /* 0: there are no necks, and what is named after them is not read. Its square: at most
                        CT_MOST_COUNT */
  const int* neckTypes;
  const double* neckHeights;   /* m of each two types */
  const double* neckDistances; /* d, nm */
  double neckScale;
  double neckCut;          /* nm */
  double coulomb;          /* kJ nm / (mol e^2), >= 0 */
  double soluteDielectric; /* > 0, as the next */
  double solventDielectric;
  double kappa;         /* 1/nm, >= 0 */
  double surfaceEnergy; /* kJ/mol/nm^2 */
  double probeRadius;   /* nm */
  double cutoff;        /* nm, > 0; INFINITY: none */
  double shift;         /* 1/nm */
} ctBorn;

/* What trials see instead of nonbonded and born, a function U1 of the state that is near both: Lennard-Jones, Coulomb
 * and Born pairs within `pairCutoff`, less the last two's value at that distance, times 10.6 x^2 - 16.2 x^3 + 6.6 x^4
 * with x = (r / pairCutoff)^2. Excluded pairs have no Lennard-Jones and Coulomb energy, but that value is subtracted
 * for them, too. The value at the cutoff is approximated by a sum of products of functions of either radius, and
 * exponentials in pairs by polynomials within 1e-4, since trials need no more; a pair has 1e6 kJ/mol at most. Born sums
 * are over particles within `bornCutoff`, each contribution less s^3 / (3 bornCutoff^4) (-2.2 + 3.4 (r /
 * bornCutoff)^2), and a constant of each particle replaces particles farther away (see ctRenewStandIn). In pairs, ln B
 * is rounded to a multiple of gridWidth, and the neglected difference is added in first order: a radius changes all
 * pairs of its particle only if it crosses the middle between two grid points. The grid is that wide for charges of
 * half an elementary one, wider (up to four times) for smaller ones, as the power -0.4 of the charge. */
typedef struct ctStandIn {
  double bornCutoff; /* nm, 1e-3 to CT_MOST_LENGTH, as the next */
  double pairCutoff;
  double gridWidth; /* 1e-4 to 1 */
} ctStandIn;

/* What an expression of a ctValueEnergy depends on. */
typedef enum ctExtent {
  ctOfParticles,
  ctOfPairs,   /* that are not excluded */
  ctOfAllPairs /* excluded ones, too */
} ctExtent;

/* An expression of the numbers of a particle or of two, see ctValueEnergy. */
typedef struct ctValueExpression {
  ctExtent extent;
  int operationCount; /* 1 to CT_MOST_OPERATIONS */
  const ctOperation* operations;
  int tableCount;
  const ctTable* tables;
} ctValueExpression;

/* An energy of values that particles have, such as radii that depend on all other particles. The numbers of a particle
 * are its parameters, then its values, then its coordinates. Each value is an expression of the numbers before it and
 * of coordinates, or the sum over all other particles within the cutoff of an expression of pairs. The energy is the
 * sum of the terms: expressions of particles, summed over all, and of pairs, which have to be the same in either order,
 * summed over all pairs within the cutoff.
 *
 * In operations of particles, parameter p is number p. In operations of pairs there are no coordinates: input 0 is the
 * distance, parameter p < parametersPerParticle + valueCount is that number of one particle (in a value, of the one
 * that has it), and the following parameters are of the other. Expressions of pairs are computed as in ctPairSet,
 * expressions of particles in double by the C library's functions. */
typedef struct ctValueEnergy {
  int parametersPerParticle; /* numbers of all particles together: at most CT_MOST_COUNT */
  const double* parameters;  /* one particle after another, finite */
  int valueCount;
  const ctValueExpression* values;
  int termCount;
  const ctValueExpression* terms;
  double cutoff; /* nm, > 0; INFINITY: none */
  int exclusionCount;
  const int (*exclusions)[2];
} ctValueEnergy;

/* The description of an energy. All arrays are the caller's, who may free them once ctCreateEnergy has returned. */
typedef struct ctEnergyDefinition {
  const ctDefinition* scene;    /* what the scene was made from, see ctHasStructure */
  const ctNonbonded* nonbonded; /* NULL: no pairs */
  const ctBorn* born;           /* NULL: none; needs nonbonded and standIn */
  const ctStandIn* standIn;     /* read with born alone */
  int pairSetCount;
  const ctPairSet* pairSets;
  int termSetCount;
  const ctTermSet* termSets;
  int valueEnergyCount;
  const ctValueEnergy* valueEnergies;
} ctEnergyDefinition;

/* The parts of an energy in the order in which trials compute them, cheapest first. */
typedef enum ctEnergyPart {
  ctTermsPart,     /* terms */
  ctNearPairsPart, /* pairs of leaves whose boxes are nearer than CT_NEAR_LEAVES before the trial or in it */
  ctOtherPairsPart /* the other pairs of leaves */
} ctEnergyPart;

enum { CT_ENERGY_PARTS = 3 };

/* nm. In a pivot, pairs this near take a tenth of the work and make more than half of the rejections by pairs. */
#define CT_NEAR_LEAVES 0.02

/* Makes the energy of a scene, in which every particle that is in a term or, with nonbonded, every particle must stand
 * in a leaf (see ctDefinition.listed). On failure *energy is NULL and errorText says why. O(N + terms). Errors:
 * a definition that contradicts the comments above; a count below 0, or so large that a multiple of it is no int. */
ctStatus ctCreateEnergy(ctChainTree* tree, const ctEnergyDefinition* definition, ctEnergy** energy, char* errorText,
                        size_t errorSize);

/* Frees an energy; NULL is ignored. */
void ctDestroyEnergy(ctEnergy* energy);

/* One sentence about the last call that failed; empty if none has. */
const char* ctGetEnergyErrorText(const ctEnergy* energy);

/* The number of terms of a set that some trial can change: by the scene's joints or, in a flexible scene, by particles
 * that are not fixed. The others cost nothing in trials. 0 if there is no such set. With isPeriodic, all count: a turn
 * changes a term that is longer than half the box's width. */
int ctCountChangeableTerms(const ctEnergy* energy, int termSet);

/* Computes all values from the scene's state. Call it before the first trial and whenever the state has changed in
 * another way than by ctAcceptEnergyChange. O(all terms and pairs). */
ctStatus ctRefreshEnergy(ctEnergy* energy, ctCounts* counts);

/* True if the stored values belong to the scene's state; else refresh the energy before the next trial. */
bool ctIsEnergyOfState(const ctEnergy* energy);

/* The energy of the state as of the last refresh and all changes accepted since: of all pairs (with born, the
 * stand-in's), of a pair set, and of a term set. O(stored values). NaN or infinite if some pair or term is; NaN if
 * there is no such set, 0 before the first refresh. */
double ctGetPairEnergy(const ctEnergy* energy);
double ctGetPairSetEnergy(const ctEnergy* energy, int pairSet);
double ctGetTermEnergy(const ctEnergy* energy, int termSet);

/* By how much the scene's open trial changes a part of the energy. Parts must be computed in their order, each
 * once a trial; later parts may be omitted if the trial is rejected. NaN if one of its values is, or some become
 * infinite and others finite. Errors: no trial; another part than the next; the energy has to be refreshed; no memory,
 * after which all parts must be computed again. */
ctStatus ctComputeEnergyChange(ctEnergy* energy, ctEnergyPart part, double* change, ctCounts* counts);

/* The change of near pairs for the reverse trial. With born, the change of near pairs is computed with the Born radii
 * before a trial, so the reverse trial's is not its opposite: this one is known once all parts were computed. Without
 * born it is the opposite of the change. A test of near pairs alone with the
 * probability a(change) has to be followed by one that multiplies by a(change back) / a(change). */
double ctGetNearChangeBack(const ctEnergy* energy);

/* To be called after ctAccept of a trial of which all parts were computed, and before anything else changes the state:
 * makes its values the stored ones, or refreshes all. Errors: a part was not computed, this is not the state to
 * which that trial has led, or there is no memory; the energy has to be refreshed then. */
ctStatus ctAcceptEnergyChange(ctEnergy* energy);

/* ---- Energies of values ---- */

/* The value energies of the scene's state, or of its open trial, recomputed at each call: functions of the positions
 * alone, so a trial's energies have the same bits once it is the state. NaN or infinite if some number is. The parts
 * above do not contain them. O(N^2) without cutoffs. Errors: `inTrial` without an open trial. */
ctStatus ctComputeValueEnergies(ctEnergy* energy, bool inTrial, double* energies);

/* ---- Two levels ---- */

/* The energies that the stand-in approximates, of the scene's state, recomputed at each call; `born` is NaN if some
 * Born radius is not a positive number. Without born, the stored pair energy, and 0. O(N^2) without
 * cutoffs. */
ctStatus ctComputeWholeEnergy(ctEnergy* energy, double* nonbonded, double* born, ctCounts* counts);

/* Sets the constant of each particle to its Born sum beyond bornCutoff in the state, if that is finite, and refreshes
 * the energy. Without born, refreshes it. O(N^2). */
ctStatus ctRenewStandIn(ctEnergy* energy, ctCounts* counts);

/* The constants: one a particle, in its order; 0 before the first renewal. After setting them, or restoring a copy that
 * was saved with others, refresh the energy. Without born there are none to read or write. Errors: a constant that is
 * not finite as a float. */
void ctGetStandIn(const ctEnergy* energy, double* constants);
ctStatus ctSetStandIn(ctEnergy* energy, const double* constants);

/* Saves a copy of all values of the state, which replaces the former copy; restores it, bit for bit, once the scene is
 * back in the state in which it was saved. O(stored values). Errors: no memory, after which there is no copy, or the
 * energy has to be refreshed; no copy was saved. */
ctStatus ctSaveEnergy(ctEnergy* energy);
ctStatus ctRestoreEnergy(ctEnergy* energy);

#ifdef __cplusplus
}
#endif

#endif /* CTENERGY_H_ */
