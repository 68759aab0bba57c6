/* elementarypath.h: the functions of elementary.h, as one instruction set has them. */
#ifndef ELEMENTARYPATH_H_
#define ELEMENTARYPATH_H_

/* Of sixteen numbers, or of sixteen times two. */
typedef void (*ElementaryFunction)(const float* x, const float* y, float* result);

typedef struct ElementaryPath {
  ElementaryFunction exp, log, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, erf, erfc, floor, ceil, inverseRoot;
  ElementaryFunction pow, atan2;
} ElementaryPath;

extern const ElementaryPath elementaryPortable;
#ifdef __x86_64__
extern const ElementaryPath elementaryAvx2;
extern const ElementaryPath elementaryAvx512;
#endif

#endif /* ELEMENTARYPATH_H_ */
