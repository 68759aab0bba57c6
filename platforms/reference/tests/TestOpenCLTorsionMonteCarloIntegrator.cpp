#include "TestTorsionMonteCarloIntegrator.h"

int main()
{
    return runOnPlatform("OpenCL", testTorsionMonteCarloIntegrator, "double");
}
