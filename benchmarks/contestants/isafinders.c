/* The finders of pairs and of least distances of the instruction set that this file is compiled for. */
#include "roster.h"

extern const PairFinder CONTESTANT(pairFinderCells);
extern const PairFinder CONTESTANT(pairFinderCellsSorted);
/* It is about answers, not about time. */
extern const PairFinder pairFinderBrute;
/* They choose among instruction sets by themselves. */
extern const PairFinder pairFinderOurs;
extern const PairFinder pairFinderOursSorted;

PairFinders CONTESTANT(pairFinders) = {
    &pairFinderBrute, &CONTESTANT(pairFinderCells), &CONTESTANT(pairFinderCellsSorted),
    &pairFinderOurs,  &pairFinderOursSorted,        NULL};

extern const NearestFinder CONTESTANT(nearestFinderBrute);
extern const NearestFinder nearestFinderOurs;

NearestFinders CONTESTANT(nearestFinders) = {&CONTESTANT(nearestFinderBrute), &nearestFinderOurs, NULL};
