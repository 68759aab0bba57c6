#include "TestPeriodicEnergies.h"

int main(int, char** arguments)
{
    return runOnPlatform(arguments[1], testPeriodicEnergies);
}
