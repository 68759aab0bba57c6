#include "TestTorsionMonteCarloIntegrator.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testTorsionMonteCarloIntegrator);
}
