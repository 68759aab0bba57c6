#include "TestTorsionMonteCarloIntegrator.h"

int main()
{
    return runOnPlatform("CPU", testTorsionMonteCarloIntegrator);
}
