/* Elementary functions against the C library's in long double: numbers of all magnitudes and signs, those where
 * something special has to happen, and dense rows of neighbours around them. And each instruction set has to give the
 * same bits. */
#include <float.h>
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "elementarypath.h"

typedef long double OfOne(long double x);
typedef long double OfTwo(long double x, long double y);

typedef struct Case {
  const char* name;
  size_t member; /* of an ElementaryPath */
  OfOne* exact;  /* or, of two numbers, the next */
  OfTwo* exactOfTwo;
  double most;  /* error, in units in the last place */
  double range; /* beyond which NaN stands for a number, or infinite */
} Case;

/* Beyond this it says nothing. */
static const float mostOfInverseRoot = 0x1p125f;

/* Below normal numbers it is infinite. */
static long double inverseRootl(long double x) {
  return x < (long double)FLT_MIN ? INFINITY : 1 / sqrtl(x);
}

#define OF_ONE(function, most, range) \
  { #function, offsetof(ElementaryPath, function), function##l, NULL, most, range }
#define OF_TWO(function, most) \
  { #function, offsetof(ElementaryPath, function), NULL, function##l, most, INFINITY }

static const Case cases[] = {
    OF_ONE(exp, 1, INFINITY),     OF_ONE(log, 1, INFINITY),
    OF_ONE(sin, 0.51, 0x1p20),    OF_ONE(cos, 0.51, 0x1p20),
    OF_ONE(tan, 0.51, 0x1p20),    OF_ONE(asin, 0.51, INFINITY),
    OF_ONE(acos, 0.51, INFINITY), OF_ONE(atan, 0.51, INFINITY),
    OF_ONE(sinh, 0.51, INFINITY), OF_ONE(cosh, 0.51, INFINITY),
    OF_ONE(tanh, 0.51, INFINITY), OF_ONE(erf, 0.51, INFINITY),
    OF_ONE(erfc, 0.51, INFINITY), OF_ONE(floor, 0, INFINITY),
    OF_ONE(ceil, 0, INFINITY),    OF_TWO(pow, 0.51),
    OF_TWO(atan2, 0.51),          OF_ONE(inverseRoot, 1.3, INFINITY),
};

static ElementaryFunction functionOf(const ElementaryPath* path, const Case* c) {
  return *(const ElementaryFunction*)(const void*)((const char*)path + c->member);
}

/* The error of a finite result in units in the last place of the float next to the exact one. */
static double errorOf(float value, long double exact) {
  int exponent;
  frexpl(exact, &exponent);
  const int last = exponent - FLT_MANT_DIG > -149 ? exponent - FLT_MANT_DIG : -149;
  return (double)(fabsl((long double)value - exact) / ldexpl(1, last));
}

static double worst = 0;

static void checkValue(const Case* c, float x, float y, float value) {
  if (c->exact == inverseRootl && (x > mostOfInverseRoot || x == -INFINITY)) {
    return;
  }
  const long double exact = c->exact != NULL ? c->exact((long double)x) : c->exactOfTwo((long double)x, (long double)y);
  const float rounded = (float)exact;
  bool isRight = isnan(rounded) ? isnan(value) : value == rounded;
  if (fabs((double)x) > c->range) {
    isRight = isnan(value);
  } else if (isfinite(rounded) && isfinite(value)) {
    const double error = errorOf(value, exact);
    worst = error > worst ? error : worst;
    isRight = error <= c->most && (value != 0 || rounded != 0 || !signbit(value) == !signbit(rounded));
  } else if (isinf(rounded) != isinf(value)) {
    /* At the edge of the range. */
    isRight = fabsf(isinf(rounded) ? value : rounded) >= FLT_MAX * (1 - 2 * FLT_EPSILON);
  }
  if (!isRight) {
    reportFailure("%s(%a, %a) is %a, not %La\n", c->name, (double)x, (double)y, (double)value, exact);
  }
}

static void checkSixteen(const Case* c, const float* x, const float* y) {
  float value[16];
  functionOf(&elementaryPortable, c)(x, y, value);
  for (int k = 0; k < 16; k++) {
    checkValue(c, x[k], y[k], value[k]);
  }
#ifdef __x86_64__
  const ElementaryPath* const others[] = {&elementaryAvx2, &elementaryAvx512};
  const bool isThere[] = {__builtin_cpu_supports("avx2") != 0,
                          __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0};
  for (int i = 0; i < 2; i++) {
    float other[16];
    if (isThere[i]) {
      functionOf(others[i], c)(x, y, other);
      for (int k = 0; k < 16; k++) {
        /* Not the bits of NaN, which stand for nothing. */
        if (memcmp(&other[k], &value[k], sizeof(float)) != 0 && !(isnan(other[k]) && isnan(value[k]))) {
          reportFailure("%s(%a, %a) has other bits on instruction set %d\n", c->name, (double)x[k], (double)y[k], i);
        }
      }
    }
  }
#endif
}

/* Each float of a row of neighbours around a number, with one other number. */
static void checkAround(const Case* c, float x, float y) {
  float row[64];
  float others[16];
  for (int k = 0; k < 32; k++) {
    row[31 - k] = k == 0 ? x : nextafterf(row[32 - k], -INFINITY);
    row[32 + k] = nextafterf(k == 0 ? x : row[31 + k], INFINITY);
    others[k % 16] = y;
  }
  for (int k = 0; k < 64; k += 16) {
    checkSixteen(c, row + k, others);
    if (c->exact == NULL) {
      checkSixteen(c, others, row + k);
    }
  }
}

static float floatOf(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

static const float special[] = {
    0,       -0.0f,   1,       -1,        0.5f,      2,        -2,      3,        -3,       88.72284f,     89,
    100,     -87.3f,  -103.9f, -104,      0.7071f,   1.41421f, 1000,    FLT_MIN,  -FLT_MIN, FLT_MAX,       -FLT_MAX,
    1e-40f,  -1e-40f, 3e-8f,   -6e-8f,    0x1p22f,   0x1p23f,  0x1p24f, -0x1p23f, 10,       -10,           0.34657f,
    1.0397f, 0.75f,   -0.75f,  1.570796f, 3.141593f, 4.5f,     0x1p20f, -0x1p20f, 9.2f,     2.71828175f,   0x1p-149f,
    11,      0.25f,   1e6f,    INFINITY,  -INFINITY, NAN,      1.5f,    -2.5f,    0.3f,     0x1.fffffep23f};

enum { SPECIAL = sizeof special / sizeof special[0] };

int main(void) {
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    const Case* c = &cases[i];
    float row[16];
    float others[16];
    worst = 0;
    for (int k = 0; k < SPECIAL; k++) {
      for (int l = 0; l < (c->exact != NULL ? 1 : SPECIAL); l++) {
        checkAround(c, special[k], special[l]);
      }
    }
    /* One float in some ten thousand, with any other. */
    for (uint64_t bits = 0; bits < (uint64_t)1 << 32;) {
      for (int k = 0; k < 16; k++, bits += 12289) {
        row[k] = floatOf((uint32_t)bits);
        others[k] = floatOf((uint32_t)(bits * 2654435761u));
      }
      checkSixteen(c, row, others);
    }
    /* Usual numbers more densely. */
    for (double x = -110; x < 110;) {
      for (int k = 0; k < 16; k++, x += 2e-4 * (1 + fabs(x))) {
        row[k] = (float)x;
        others[k] = (float)(k < 4 ? k - 2 : 3 * sin(1e5 * x));
      }
      checkSixteen(c, row, others);
    }
    printf("%s: at most %.3f units in the last place\n", c->name, worst);
  }
  return checkResult();
}
