#include "TestCheckpoints.h"

int main()
{
    return runOnPlatform("CPU", testCheckpoints);
}
