#include "TestAgreementWithReference.h"

int main()
{
    return runOnPlatform("OpenCL", [](Platform& platform) {
        for (const string precision : {"single", "mixed", "double"}) {
            platform.setPropertyDefaultValue("Precision", precision);
            testAgreementWithReference(platform);
        }
    });
}
