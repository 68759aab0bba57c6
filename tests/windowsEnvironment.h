/* windowsEnvironment.h: what tests call to set environment variables, where the C library has it by other names. */
#ifndef WINDOWS_ENVIRONMENT_H_
#define WINDOWS_ENVIRONMENT_H_

#include <stdlib.h>

static inline int setenv(const char* name, const char* value, int overwrite)
{
    return overwrite || getenv(name) == NULL ? _putenv_s(name, value) : 0;
}

static inline int unsetenv(const char* name)
{
    return _putenv_s(name, "");
}

#endif /* WINDOWS_ENVIRONMENT_H_ */
