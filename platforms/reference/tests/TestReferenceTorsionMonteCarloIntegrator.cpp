#include "TestTorsionMonteCarloIntegrator.h"

int main()
{
    return runOnPlatform("Reference", testTorsionMonteCarloIntegrator);
}
