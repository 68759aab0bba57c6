#include "TestCheckpoints.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testCheckpoints);
}
