/* ctdensity.h: probability densities from which torsions are drawn, independent of their present values.
 *
 * A density belongs to a set of torsions, such as all torsions of a side chain, and is normalized: its integral over
 * all their angles is 1. What is drawn has exactly the density that is evaluated. It is above 0 everywhere, so that
 * every state can be left as well as reached; the caller sees to that by values above 0 or by a floor.
 *
 * Angles are in rad, densities per rad^torsionCount. A density is never changed once it is made, so threads can share
 * it. Only the two functions that make one allocate memory.
 *
 * Arguments. A function that makes a density returns NULL for what contradicts its comment, as it does without memory.
 * Other pointers may be NULL where a comment says so; elsewhere a call with NULL does nothing and returns 0 or NaN. */
#ifndef CT_DENSITY_H_
#define CT_DENSITY_H_

#ifdef __cplusplus
extern "C" {
#endif

/* The most torsions of a density, and the most numbers that drawing them takes. */
#define CT_DENSITY_MOST 8
#define CT_UNIFORMS_MOST (1 + 4 * CT_DENSITY_MOST)

/* The most bins of a table, and rotamers. */
#define CT_BINS_MOST 536870911

/* rad. Means and widths beyond this are refused; between this and half a turn they are the caller's mistake. */
#define CT_MOST_ANGLE 10.0

typedef struct ctDensity ctDensity;

/* Makes a density that is constant in each bin of a periodic grid. The circle of torsion k, of 1 to CT_DENSITY_MOST, is
 * cut into binCounts[k] bins of equal width, the first of which begins at -pi; all together there are at most
 * CT_BINS_MOST. values[b] is proportional to the density in bin b, the index of the last torsion running fastest; it is
 * finite and at least 0, and the sum is finite and above 0. A share `floor`, in [0, 1], of the draws is uniform.
 * Returns NULL if there is no memory. */
ctDensity* ctCreateTable(int torsionCount, const int* binCounts, const double* values, double floor);

/* Makes a density with a peak at each of some rotamers: a product of bells, one a torsion. A bell is a cubic B-spline
 * of that mean and standard deviation, wrapped around the circle: at most .015/deviation from a normal density, and 0
 * from 3.46 deviations on, so that no exponential is needed to draw or evaluate it. A share `floor`, in [0, 1], of the
 * draws of each torsion is uniform instead, whatever becomes of the others. `weights` are rotamerCount (1 or more)
 * numbers, finite and at least 0, of a sum above 0: proportional to how often each rotamer is drawn. `means` are
 * rotamerCount rows of torsionCount angles, in [-pi, pi], and `widths` as many standard deviations, in (0, pi]. Returns
 * NULL if there is no memory. */
ctDensity* ctCreateRotamers(int torsionCount, int rotamerCount, const double* weights, const double* means,
                            const double* widths, double floor);

/* NULL is allowed. */
void ctDestroyDensity(ctDensity* density);

/* How many uniform numbers ctDrawAngles() takes, at most CT_UNIFORMS_MOST. */
int ctCountUniforms(const ctDensity* density);

/* Draws angles, in [-pi, pi], from independent uniform numbers in [0, 1). Takes O(torsionCount) time. Of other numbers
 * the angles are of no use. */
void ctDrawAngles(const ctDensity* density, const double* uniforms, double* angles);

/* The density at these angles, in [-pi, pi]. Takes O(torsionCount) time for a table, O(torsionCount rotamerCount) for
 * rotamers. At other angles it is of no use, NaN included. */
double ctGetDensity(const ctDensity* density, const double* angles);

#ifdef __cplusplus
}
#endif

#endif /* CT_DENSITY_H_ */
