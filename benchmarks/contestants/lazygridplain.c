/* The lazy grid, searched for one particle after the other. */
#define BATCHED 0

#include "lazygrid.h"

const Contestant CONTESTANT(contestantLazyGridPlain) =
    LAZY_GRID("lazygrid-plain", "the same as lazygrid, but searched for one particle after the other");
