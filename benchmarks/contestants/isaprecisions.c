/* What the measures of exactness compare, of the instruction set that this file is compiled for. */
#include "roster.h"

extern const Contestant CONTESTANT(contestantAllSingle);
extern const Contestant CONTESTANT(contestantLazyGridSingle);
extern const Contestant CONTESTANT(contestantVolumesDouble);
extern const Contestant CONTESTANT(contestantVolumesDoubleMargin);
extern const Contestant CONTESTANT(contestantVolumesSingle);
extern const Contestant CONTESTANT(contestantVolumesSingleMargin);
/* They choose instruction sets by themselves, as the engine's kinematics below. */
extern const Contestant contestantOursAvx512;
extern const Contestant contestantOursAvx2;
extern const Contestant contestantOursPortable;
extern const Contestant contestantOursTree;
extern const Contestant contestantOursBoxes;
extern const Contestant contestantOursClearances;
extern const Contestant contestantOursWhole;

Roster CONTESTANT(precisions) = {&contestantOursAvx512,
                                 &contestantOursAvx2,
                                 &contestantOursPortable,
                                 &contestantOursTree,
                                 &contestantOursBoxes,
                                 &contestantOursClearances,
                                 &contestantOursWhole,
                                 &CONTESTANT(contestantVolumesDouble),
                                 &CONTESTANT(contestantVolumesDoubleMargin),
                                 &CONTESTANT(contestantVolumesSingle),
                                 &CONTESTANT(contestantVolumesSingleMargin),
                                 &CONTESTANT(contestantAllSingle),
                                 &CONTESTANT(contestantLazyGridSingle),
                                 NULL};

extern const Kinematics kinematicsOursAvx512;
extern const Kinematics kinematicsOursAvx2;
extern const Kinematics kinematicsOursPortable;
extern const Kinematics CONTESTANT(kinematicsCartesian);
extern const Kinematics CONTESTANT(kinematicsCartesianSingle);
extern const Kinematics CONTESTANT(kinematicsMultiplied);
extern const Kinematics CONTESTANT(kinematicsMultipliedSingle);
extern const Kinematics CONTESTANT(kinematicsSequential);
extern const Kinematics CONTESTANT(kinematicsSequentialSingle);
extern const Kinematics CONTESTANT(kinematicsShortcuts);
extern const Kinematics CONTESTANT(kinematicsShortcutsSingle);

KinematicsRoster CONTESTANT(kinematics) = {&kinematicsOursAvx512,
                                           &kinematicsOursAvx2,
                                           &kinematicsOursPortable,
                                           &CONTESTANT(kinematicsShortcuts),
                                           &CONTESTANT(kinematicsShortcutsSingle),
                                           &CONTESTANT(kinematicsMultiplied),
                                           &CONTESTANT(kinematicsMultipliedSingle),
                                           &CONTESTANT(kinematicsCartesian),
                                           &CONTESTANT(kinematicsCartesianSingle),
                                           &CONTESTANT(kinematicsSequential),
                                           &CONTESTANT(kinematicsSequentialSingle),
                                           NULL};
