#include "TestStericExclusionForce.h"

int main()
{
    return runOnPlatform("CPU", testStericExclusionForce);
}
