/* ctclosure.h: windows of torsions that turn while the chain behind them stays in place.
 *
 * A window is a row of torsions along a chain. Turning torsion i by a_i turns the chain behind it about its axis, so
 * the tail, the chain behind the last torsion, moves by the product E_0(a_0) E_1(a_1) ... E_n-1(a_n-1), where E_i(a) is
 * the rotation by a about axis i as the axis lies now. The window closes if this product is the identity. Six of its
 * torsions, the pivots, are solved for; the others, the drivers, are given.
 *
 * With U uniform in torsions and both ends fixed, the density per volume of the drivers is 1/|J|, J being the 6 x 6
 * determinant of the pivots' screws (u, r x u). So a move that draws drivers with the same density in both directions
 * is accepted with |J| / |J'| exp(-beta dU), where the prime marks the new state, if it is reversible: Newton's method
 * from the new state has to end on the old one. A move that draws one of all closures by weights g, which are the same
 * in both directions, has the ratio |J| Z / (|J'| Z') with the sums Z of the weights of all closures; the old state has
 * to be among the closures of the reverse move.
 *
 * Lengths are in nm, angles in rad. No call allocates memory. Everything is a pure function of its arguments. Pointers
 * may be NULL nowhere: then a call does nothing and returns false, 0 or NaN. Numbers that are not finite, or too large
 * for the squares of their products, make invalid results, but no other harm. */
#ifndef CT_CLOSURE_H_
#define CT_CLOSURE_H_

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The most torsions of a window, and the number that close it. */
#define CT_WINDOW_MOST 16
#define CT_PIVOTS 6

/* The most solutions of a closure. */
#define CT_CLOSURES_MOST 16

/* A window as it lies now. A positive turn about an axis is right-handed. */
typedef struct ctWindow {
  int count;                        /* torsions, CT_PIVOTS to CT_WINDOW_MOST */
  int pivots[CT_PIVOTS];            /* which of them close the window, ascending; the axes of the first and second, of
                                       the third and fourth and of the fifth and sixth meet in a point each, and no
                                       torsion lies between these two */
  double points[CT_WINDOW_MOST][3]; /* nm, a point of each axis; of pivots the point where the two meet */
  double axes[CT_WINDOW_MOST][3];   /* unit vectors, from the root to the tail */
} ctWindow;

/* Turns the torsions of a window: its axes as they lie after turns by `angles` (one a torsion). `turned` may be the
 * window itself. A window with another count than it may have is copied as it is. */
void ctTurnWindow(const ctWindow* window, const double* angles, ctWindow* turned);

/* log |J| of a window as it lies, in nm^3; -inf if its pivots' points lie on a line; NaN if its torsions are no window.
 */
double ctComputeLogJacobian(const ctWindow* window);

/* Closes a window by Newton's method, from where it is: `angles` holds the turns of the drivers, and receives the turns
 * of the pivots, in [-pi, pi]. The tail is where it was up to rounding: 5e-14 nm at 10 nm from the window. False if it
 * does not converge, or if the window is none: torsions out of order, parallel axes in a point, points on a line. */
bool ctCloseNear(const ctWindow* window, double* angles);

/* Finds all ways to close a window after the drivers' turns in `angles`: turns of the six pivots, in [-pi, pi], each
 * closing it as well as ctCloseNear does. Their order means nothing. Returns their number; 0 for what is no window.
 * Close to a singularity (|J| below 1e-6 nm^3) one can be missed. */
int ctFindClosures(const ctWindow* window, const double* angles, double solutions[CT_CLOSURES_MOST][CT_PIVOTS]);

#ifdef __cplusplus
}
#endif

#endif /* CT_CLOSURE_H_ */
