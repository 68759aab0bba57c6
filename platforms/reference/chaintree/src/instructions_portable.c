#define INSTRUCTION_SET ctPortable
#define INSTRUCTION_SET_NAME "portable"
#include "instructions_body.h"
