#include "TestStericExclusionForce.h"

int main()
{
    return runOnPlatform("Reference", testStericExclusionForce);
}
