#include "scene.h"

#include <stdarg.h>
#include <stdio.h>

ctStatus ctFail(ctChainTree* scene, ctStatus status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(scene->errorText, sizeof scene->errorText, format, arguments);
  va_end(arguments);
  return status;
}

ctStatus ctFailOutOfMemory(ctChainTree* scene) {
  return ctFail(scene, ctOutOfMemory, "out of memory");
}
