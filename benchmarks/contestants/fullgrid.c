/* The paper's Grid, searched for some particles at a time. */
#define BATCHED 1

#include "fullgrid.h"

const Contestant CONTESTANT(contestantFullGrid) =
    FULL_GRID("fullgrid", "the paper's Grid: a cell grid of all particles, made anew");
