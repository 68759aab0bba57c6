/* The contestants of the instruction set that this file is compiled for. */
#include "roster.h"

extern const Contestant CONTESTANT(contestantBrute);
extern const Contestant CONTESTANT(contestantFullGrid);
extern const Contestant CONTESTANT(contestantLazyGrid);
/* It chooses among instruction sets by itself. */
extern const Contestant contestantOurs;

Roster CONTESTANT(roster) = {&CONTESTANT(contestantBrute), &CONTESTANT(contestantFullGrid),
                             &CONTESTANT(contestantLazyGrid), &contestantOurs, NULL};
