#include "TestCheckpoints.h"

int main()
{
    return runOnPlatform("Reference", testCheckpoints);
}
