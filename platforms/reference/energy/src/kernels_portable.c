#define KERNELS ctPortableKernels
#define KERNELS_NAME "portable"
#include "kernels_body.h"
