#define PATH portablePath
#include "elementarypath_body.h"
