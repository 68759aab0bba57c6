#include "TestStericExclusionForce.h"

int main()
{
    return runOnPlatform("OpenCL", testStericExclusionForce, "double");
}
