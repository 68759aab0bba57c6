#include "TestNativeEnergies.h"

int main()
{
    return runOnPlatform("CPU", testNativeEnergies);
}
