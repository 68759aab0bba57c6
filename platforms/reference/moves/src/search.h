/* search.h: all ways to close a triangle. */
#ifndef CT_SEARCH_H_
#define CT_SEARCH_H_

#include "triangle.h"

/* Finds them. Returns their number. */
int findSways(const Triangle* triangle, Sway sways[CT_CLOSURES_MOST]);

#endif /* CT_SEARCH_H_ */
