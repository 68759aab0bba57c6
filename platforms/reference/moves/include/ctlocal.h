/* ctlocal.h: steps of a window of torsions that leave what lies behind it nearly where it is.
 *
 * Favrin, Irback and Sjunnesson, J. Chem. Phys. 114, 8154 (2001). The window is a row of torsions along a chain.
 * Turning one of them turns all that lies behind it about its axis. Three particles behind the last torsion, the ends,
 * say where the rest of the chain is. Turns d of all torsions are drawn from a normal distribution, whose density is
 *
 *     sqrt(det A) / (2 pi)^(n/2) exp(-d A d / 2),   A = (I + stiffness G) / sigma^2,
 *     G_ij = sum_k dr_k/da_i . dr_k/da_j,
 *
 * r_k being the positions of the ends and a_i the angles: what shifts the ends is rare. A and so the density are others
 * where the step leads, which is what the acceptance of a step has to mend.
 *
 * Lengths are in nm, angles in rad. No call allocates memory. Everything is a pure function of its arguments. With a
 * pointer that is NULL, or steps or a window of another count than they may have, a call does nothing and returns false
 * or NaN.
 */
#ifndef CT_LOCAL_H_
#define CT_LOCAL_H_

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The most torsions of a window. */
#define CT_LOCAL_MOST 32

#define CT_LOCAL_ENDS 3

/* A window as it lies now. A positive turn about an axis is right-handed. */
typedef struct ctLocalWindow {
  int count;                       /* torsions, 1 to CT_LOCAL_MOST */
  double points[CT_LOCAL_MOST][3]; /* nm, a point of each axis */
  double axes[CT_LOCAL_MOST][3];   /* unit vectors, from the root to the ends */
  double ends[CT_LOCAL_ENDS][3];   /* nm, behind the last torsion or on its axis */
} ctLocalWindow;

/* The distribution of steps from where a window lies. */
typedef struct ctLocalSteps {
  int count;
  double sigma;                                /* rad */
  double factor[CT_LOCAL_MOST][CT_LOCAL_MOST]; /* the lower triangle L of I + stiffness G = L L^T */
} ctLocalSteps;

/* Computes the distribution of steps.
 *
 * sigma: standard deviation of a turn that shifts no end, above 0, in rad.
 * stiffness: how rare shifts are, at least 0, in 1/nm^2: an end that a turn of a radian shifts by r makes its standard
 *   deviation smaller, by 1/sqrt(1 + stiffness r^2) if nothing makes up for it.
 *
 * False if there is none within rounding: a number is not finite or out of its range, or the stiffness is so large that
 * the identity is nothing beside it. The steps are then of count 0. */
bool ctFindLocalSteps(const ctLocalWindow* window, double sigma, double stiffness, ctLocalSteps* steps);

/* Makes a step of `count` independent normal numbers of variance 1. */
void ctDrawLocalStep(const ctLocalSteps* steps, const double* normals, double* changes);

/* The logarithm of the density of a step, without the constant (2 pi)^(n/2). That of the step back is the density of
 * the negative changes by the distribution where it leads. */
double ctComputeLocalLogDensity(const ctLocalSteps* steps, const double* changes);

/* Turns the torsions of a window: where its axes and ends are after a step. */
void ctTurnLocalWindow(const ctLocalWindow* window, const double* changes, ctLocalWindow* turned);

#ifdef __cplusplus
}
#endif

#endif /* CT_LOCAL_H_ */
