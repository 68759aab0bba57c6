#define CT_DESCENT ctDescentPortable
#define CT_DESCENT_NAME "portable"
#include "descent_body.h"
