#include "TestCheckpoints.h"

int main()
{
    return runOnPlatform("OpenCL", testCheckpoints, "double");
}
