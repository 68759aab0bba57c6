/* The contestants of the instruction set that this file is compiled for. Those that name no instructions are compiled
 * for no more than AVX2: what gcc makes of them with AVX-512 is slower. Those of the engine choose among instruction
 * sets by themselves. */
#include "lanes.h"
#include "roster.h"

#if defined(__AVX512F__)
#define PLAIN(name) CONTESTANT_JOIN(name, Avx2)
#define PLAIN_ISA "avx2"
#else
#define PLAIN CONTESTANT
#define PLAIN_ISA LANES_ISA
#endif

#define CONTESTANTS(DO)                     \
  DO(PLAIN(contestantBrute))                \
  DO(PLAIN(contestantFullGrid))             \
  DO(PLAIN(contestantFullGridPlain))        \
  DO(PLAIN(contestantImproved))             \
  DO(PLAIN(contestantKObbTree))             \
  DO(PLAIN(contestantKObbTreeLeaves))       \
  DO(PLAIN(contestantLazyGrid))             \
  DO(PLAIN(contestantLazyGridPlain))        \
  DO(PLAIN(contestantObbTree1))             \
  DO(PLAIN(contestantObbTree1Leaves))       \
  DO(PLAIN(contestantPublished))            \
  DO(PLAIN(contestantPublishedCapsules))    \
  DO(PLAIN(contestantPublishedSelvesFirst)) \
  DO(PLAIN(contestantPublishedSpheres))     \
  DO(PLAIN(contestantPublishedTight))       \
  DO(PLAIN(contestantVerletList))           \
  DO(CONTESTANT(contestantSimdGrid))        \
  DO(contestantOurs)

#define PRECISIONS(DO)                     \
  DO(contestantOursAvx512)                 \
  DO(contestantOursAvx2)                   \
  DO(contestantOursPortable)               \
  DO(contestantOursTree)                   \
  DO(contestantOursBoxes)                  \
  DO(contestantOursClearances)             \
  DO(contestantOursWhole)                  \
  DO(PLAIN(contestantVolumesDouble))       \
  DO(PLAIN(contestantVolumesDoubleMargin)) \
  DO(PLAIN(contestantVolumesSingle))       \
  DO(PLAIN(contestantVolumesSingleMargin)) \
  DO(PLAIN(contestantAllSingle))           \
  DO(PLAIN(contestantLazyGridSingle))

#define KINEMATICS(DO)                  \
  DO(kinematicsOursAvx512)              \
  DO(kinematicsOursAvx2)                \
  DO(kinematicsOursPortable)            \
  DO(PLAIN(kinematicsShortcuts))        \
  DO(PLAIN(kinematicsShortcutsSingle))  \
  DO(PLAIN(kinematicsMultiplied))       \
  DO(PLAIN(kinematicsMultipliedSingle)) \
  DO(PLAIN(kinematicsCartesian))        \
  DO(PLAIN(kinematicsCartesianSingle))  \
  DO(PLAIN(kinematicsSequential))       \
  DO(PLAIN(kinematicsSequentialSingle))

#define PAIR_FINDERS(DO)                \
  DO(pairFinderBrute)                   \
  DO(CONTESTANT(pairFinderCells))       \
  DO(CONTESTANT(pairFinderCellsSorted)) \
  DO(pairFinderOurs)                    \
  DO(pairFinderOursSorted)

#define NEAREST_FINDERS(DO)          \
  DO(CONTESTANT(nearestFinderBrute)) \
  DO(nearestFinderOurs)

#define DECLARE_CONTESTANT(name) extern const Contestant name;
#define DECLARE_KINEMATICS(name) extern const Kinematics name;
#define DECLARE_PAIR_FINDER(name) extern const PairFinder name;
#define DECLARE_NEAREST_FINDER(name) extern const NearestFinder name;
#define ADDRESS(name) &name,

CONTESTANTS(DECLARE_CONTESTANT)
PRECISIONS(DECLARE_CONTESTANT)
KINEMATICS(DECLARE_KINEMATICS)
PAIR_FINDERS(DECLARE_PAIR_FINDER)
NEAREST_FINDERS(DECLARE_NEAREST_FINDER)

static const Contestant* const contestants[] = {CONTESTANTS(ADDRESS) NULL};
static const Contestant* const precisions[] = {PRECISIONS(ADDRESS) NULL};
static const Kinematics* const kinematics[] = {KINEMATICS(ADDRESS) NULL};
static const PairFinder* const pairFinders[] = {PAIR_FINDERS(ADDRESS) NULL};
static const NearestFinder* const nearestFinders[] = {NEAREST_FINDERS(ADDRESS) NULL};

const InstructionSet CONTESTANT(instructionSet) = {.name = LANES_ISA,
                                                   .contestantsName = PLAIN_ISA,
                                                   .contestants = contestants,
                                                   .precisions = precisions,
                                                   .kinematics = kinematics,
                                                   .pairFinders = pairFinders,
                                                   .nearestFinders = nearestFinders};
