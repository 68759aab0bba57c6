#include "TestAgreementWithReference.h"

int main()
{
    return runAtEveryPrecision("OpenCL", testAgreementWithReference);
}
