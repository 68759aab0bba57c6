/* The contestants of the instruction set that this file is compiled for. */
#include "roster.h"

extern const Contestant CONTESTANT(contestantBrute);
extern const Contestant CONTESTANT(contestantFullGrid);
extern const Contestant CONTESTANT(contestantFullGridPlain);
extern const Contestant CONTESTANT(contestantImproved);
extern const Contestant CONTESTANT(contestantKObbTree);
extern const Contestant CONTESTANT(contestantKObbTreeLeaves);
extern const Contestant CONTESTANT(contestantLazyGrid);
extern const Contestant CONTESTANT(contestantLazyGridPlain);
extern const Contestant CONTESTANT(contestantObbTree1);
extern const Contestant CONTESTANT(contestantObbTree1Leaves);
extern const Contestant CONTESTANT(contestantPublished);
extern const Contestant CONTESTANT(contestantPublishedCapsules);
extern const Contestant CONTESTANT(contestantPublishedSpheres);
extern const Contestant CONTESTANT(contestantPublishedTight);
/* It chooses among instruction sets by itself. */
extern const Contestant contestantOurs;

Roster CONTESTANT(contestants) = {&CONTESTANT(contestantBrute),
                                  &CONTESTANT(contestantFullGrid),
                                  &CONTESTANT(contestantFullGridPlain),
                                  &CONTESTANT(contestantImproved),
                                  &CONTESTANT(contestantKObbTree),
                                  &CONTESTANT(contestantKObbTreeLeaves),
                                  &CONTESTANT(contestantLazyGrid),
                                  &CONTESTANT(contestantLazyGridPlain),
                                  &CONTESTANT(contestantObbTree1),
                                  &CONTESTANT(contestantObbTree1Leaves),
                                  &CONTESTANT(contestantPublished),
                                  &CONTESTANT(contestantPublishedCapsules),
                                  &CONTESTANT(contestantPublishedSpheres),
                                  &CONTESTANT(contestantPublishedTight),
                                  &contestantOurs,
                                  NULL};
