#include "TestAgreementWithReference.h"

int main(int, char** arguments)
{
    return runOnPlatform(arguments[1], testAgreementWithReference);
}
