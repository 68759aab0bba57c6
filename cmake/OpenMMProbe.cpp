/* Prints the version of the OpenMM it is linked with. The call with a std::string, made only if there is an argument,
 * lets it link only where OpenMM was built with the same string ABI. */
#include "openmm/Platform.h"
#include <iostream>

int main(int argc, char** argv)
{
    if (argc > 1)
        OpenMM::Platform::loadPluginLibrary(argv[1]);
    std::cout << OpenMM::Platform::getOpenMMVersion();
}
