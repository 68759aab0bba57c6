/* The lazy grid, searched for some particles at a time. */
#define BATCHED 1

#include "lazygrid.h"

const Contestant CONTESTANT(contestantLazyGrid) = LAZY_GRID("lazygrid", "a cell grid that moves only the shorter side");
