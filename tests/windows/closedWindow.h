/* closedWindow.h: windows of torsions that close, by Newton's method: what lies behind them stays where it is. And
 * chains to try them on. */
#ifndef CLOSED_WINDOW_H_
#define CLOSED_WINDOW_H_

#include "oracle/randomScene.h"

#include <stdbool.h>

enum { SIDE = 2 }; /* particles of a link of a chain: one on it, one beside it */

/* A chain that does not fold back at once; its first link is free, each other hangs on the one before by a torsion. */
randomScene makeChainScene(randomSource* random, int links);

enum { MOST_WINDOW = 16 };

/* The axes of consecutive torsions, each of which moves all that follow, in the state. */
typedef struct Window {
    int count;
    double points[MOST_WINDOW][3];
    double directions[MOST_WINDOW][3]; /* unit vectors */
} Window;

/* The axes of the torsions of these links of a chain. */
Window readWindow(const double* positions, int link, int size);

/* Given the angles of all but the last six torsions, finds those of the last six by which the window moves what lies
 * behind it by `shift` and nothing else. False if the method does not converge to solutions near 0. */
bool closeWindow(const Window* window, const double shift[3], double* angles);

#endif /* CLOSED_WINDOW_H_ */
