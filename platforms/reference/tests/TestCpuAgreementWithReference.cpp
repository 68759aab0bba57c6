#include "TestAgreementWithReference.h"

int main()
{
    return runOnPlatform("CPU", testAgreementWithReference);
}
