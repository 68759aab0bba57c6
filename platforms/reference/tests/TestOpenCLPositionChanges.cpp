#include "TestPositionChanges.h"

int main()
{
    return runOnPlatform("OpenCL", testPositionChanges, "double");
}
