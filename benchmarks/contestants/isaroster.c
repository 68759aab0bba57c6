/* The contestants of the instruction set that this file is compiled for. Contestants that name no instructions are
 * compiled for no more than AVX2: gcc's code for AVX-512 is slower. Contestants of the engine choose their own
 * instruction set. */
#include "lanes.h"
#include "roster.h"

#if defined(__AVX512F__)
#define PLAIN(name) CONTESTANT_JOIN(name, Avx2)
#else
#define PLAIN CONTESTANT
#endif

#define CONTESTANTS(DO)              \
  DO(PLAIN(contestantBrute))         \
  DO(PLAIN(contestantFullGrid))      \
  DO(PLAIN(contestantLazyGrid))      \
  DO(PLAIN(contestantVerletList))    \
  DO(PLAIN(contestantObbTree1))      \
  DO(PLAIN(contestantKObbTree))      \
  DO(PLAIN(contestantPublished))     \
  DO(PLAIN(contestantImproved))      \
  DO(CONTESTANT(contestantSimdGrid)) \
  DO(contestantOurs)

#define DECLARE(name) extern const Contestant name;
#define ADDRESS(name) &name,

CONTESTANTS(DECLARE)
extern const PairFinder pairFinderBrute;
extern const PairFinder CONTESTANT(pairFinderCells);
extern const PairFinder pairFinderOurs;

static const Contestant* const contestants[] = {CONTESTANTS(ADDRESS) NULL};
static const PairFinder* const pairFinders[] = {&pairFinderBrute, &CONTESTANT(pairFinderCells), &pairFinderOurs, NULL};

const InstructionSet CONTESTANT(instructionSet) = {
    .name = LANES_ISA, .contestants = contestants, .pairFinders = pairFinders};
