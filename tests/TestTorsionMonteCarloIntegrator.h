/**
 * This tests TorsionMonteCarloIntegrator on one platform. What takes longest comes last.
 */

#include "TestMoves.h"
#include "TestSampledDistributions.h"
#include "TestSamplingEnergies.h"
#include "TestSamplingSteps.h"

void testTorsionMonteCarloIntegrator(OpenMM::Platform& platform)
{
    testMoves(platform);
    testSamplingSteps(platform);
    testSamplingEnergies(platform);
    testSampledDistributions(platform);
}
