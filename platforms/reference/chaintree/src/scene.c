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

Tree* ctSceneTree(ctChainTree* scene) {
  if (scene->staleTree.isStale) {
    ctSequenceRefresh(&scene->sequence);
    ctTreeRefresh(&scene->staleTree, &scene->sequence);
  }
  return &scene->staleTree;
}

ctStatus ctFailOutOfMemory(ctChainTree* scene) {
  return ctFail(scene, ctOutOfMemory, "out of memory");
}
