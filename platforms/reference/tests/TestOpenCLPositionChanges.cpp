#include "TestPositionChanges.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testPositionChanges);
}
