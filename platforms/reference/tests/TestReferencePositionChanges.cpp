#include "TestPositionChanges.h"

int main()
{
    return runOnPlatform("Reference", testPositionChanges);
}
