/* elementarypath.h: the functions of elementary.h, as one instruction set has them. */
#ifndef ELEMENTARYPATH_H_
#define ELEMENTARYPATH_H_

/* Of sixteen numbers. */
typedef void (*ElementaryFunction)(const float* x, float* result);

typedef struct ElementaryPath {
  ElementaryFunction exp;
  ElementaryFunction log;
} ElementaryPath;

extern const ElementaryPath portablePath;
#ifdef __x86_64__
extern const ElementaryPath avx2Path;
extern const ElementaryPath avx512Path;
#endif

#endif /* ELEMENTARYPATH_H_ */
