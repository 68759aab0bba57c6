/**
 * This tests what of sampling is kept in checkpoints and States, on one platform.
 */

#include "TestDamagedCheckpoints.h"
#include "TestLoadedCheckpoints.h"
#include "TestRemadeContexts.h"
#include "TestStates.h"

void testCheckpoints(OpenMM::Platform& platform)
{
    testLoadedCheckpoints(platform);
    testRemadeContexts(platform);
    testStates(platform);
    testDamagedCheckpoints(platform);
}
