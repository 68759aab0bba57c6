/* triangle.h: a window without its drivers. Once these have turned, what lies between the pivots' three points is
 * rigid, and so is what lies between the last point and the first, through the tail and the root. The points are the
 * corners of a triangle of known sides; each of the three pieces can turn about the side that it spans; and the window
 * is closed if the two axes meet in each corner at the angle that they had: three equations in three turns, each
 * bilinear in the cosines and sines of two of them.
 *
 * Corner k has the piece k - 1 before it, to which the first of its two pivots belongs, and the piece k after it, to
 * which the second belongs; indices are modulo 3.
 */
#ifndef CT_TRIANGLE_H_
#define CT_TRIANGLE_H_

#include "ctclosure.h"

/* The axes of a corner as a piece has them: along its side, in the triangle's plane across the side, along the normal
 * of the plane; before the piece turns. */
typedef struct Corner {
  double first[3];
  double second[3];
} Corner;

typedef struct Triangle {
  double sides[3];      /* nm; from corner k to the next */
  double tangent[3][2]; /* direction of each side in the plane; their turns from one to the next are to the left */
  double cosines[3];    /* of the turn in each corner, from the side before it to that after it */
  double sines[3];
  double angles[3]; /* cosine of the angle of the axes in each corner */
  Corner before[3]; /* of each corner, in the piece before it */
  Corner after[3];  /* of each corner, in the piece after it */
} Triangle;

/* Turns of the three pieces about their sides: cosines and sines. */
typedef struct Sway {
  double c[3];
  double s[3];
} Sway;

/* True if torsions are so arranged that a window can be closed: neighbors pair by pair, each pair with a point. */
bool isWindow(const ctWindow* window);

/* The triangle of a window whose drivers turn by `angles`. Its pieces lie so that what they have in common with the
 * window as it is now is near where it is now, if drivers turn by little. False if there is none, or if the window is
 * none that can be closed. */
bool makeTriangle(const ctWindow* window, const double* angles, Triangle* triangle);

/* Closes it by Newton's method. */
bool closeTriangle(const Triangle* triangle, Sway* sway);

/* The turns of the pivots that make the closed triangle of the window. False if they are no numbers, as for axes whose
 * squares overflow. */
bool turnsOfTriangle(const Triangle* triangle, const Sway* sway, double turns[CT_PIVOTS]);

#endif /* CT_TRIANGLE_H_ */
