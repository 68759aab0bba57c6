#include "TestNativeEnergies.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testNativeEnergies);
}
