#include "TestPeriodicBoxes.h"

int main(int, char** arguments)
{
    return runOnPlatform(arguments[1], testPeriodicBoxes);
}
