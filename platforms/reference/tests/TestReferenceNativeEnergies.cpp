#include "TestNativeEnergies.h"

int main()
{
    return runOnPlatform("Reference", testNativeEnergies);
}
