#include "TestStericExclusionForce.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testStericExclusionForce);
}
