#include "TestPositionChanges.h"

int main()
{
    return runOnPlatform("CPU", testPositionChanges);
}
