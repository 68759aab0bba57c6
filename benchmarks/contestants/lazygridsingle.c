/* The lazy grid with positions in single precision. */
#define BATCHED 1
#define SINGLE 1

#include "lazygrid.h"

const Contestant CONTESTANT(contestantLazyGridSingle) = LAZY_GRID("lazygrid-single",
                                                                  "the lazy grid with positions kept in single");
