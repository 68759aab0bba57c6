/**
 * This tests StericExclusionForce on one platform.
 */

#include "TestStericContexts.h"
#include "TestStericQueries.h"
#include "TestTrials.h"

void testStericExclusionForce(OpenMM::Platform& platform)
{
    testStericQueries(platform);
    testTrials(platform);
    testStericContexts(platform);
}
