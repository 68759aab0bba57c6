/* The paper's Grid, searched for one particle after the other. */
#define BATCHED 0

#include "fullgrid.h"

const Contestant CONTESTANT(contestantFullGridPlain) =
    FULL_GRID("fullgrid-plain", "the same as fullgrid, but searched for one particle after the other");
