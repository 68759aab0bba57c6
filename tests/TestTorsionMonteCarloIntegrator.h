/**
 * This tests TorsionMonteCarloIntegrator on one platform. What takes longest comes last.
 */

#include "TestMoves.h"
#include "TestSampledDistributions.h"
#include "TestSamplingEnergies.h"
#include "TestSamplingSteps.h"
#include "TestTurnedVelocities.h"

void testTorsionMonteCarloIntegrator(OpenMM::Platform& platform)
{
    testMoves(platform);
    testSamplingSteps(platform);
    testTurnedVelocities(platform);
    testSamplingEnergies(platform);
    testSampledDistributions(platform);
}
