/* Elementary functions against the C library's in long double: numbers of all magnitudes and signs, those where
 * something special has to happen, and dense rows of neighbours around them. And each instruction set has to give the
 * same bits. */
#include <float.h>
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "elementarypath.h"

typedef struct Case {
  const char* name;
  size_t member; /* of an ElementaryPath */
  long double (*exact)(long double x);
  double most; /* error, in units in the last place */
} Case;

static const Case cases[] = {
    {"exp", offsetof(ElementaryPath, exp), expl, 1},
    {"log", offsetof(ElementaryPath, log), logl, 1},
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

static void checkValue(const Case* c, float x, float value) {
  const long double exact = c->exact((long double)x);
  const float rounded = (float)exact;
  bool isRight = isnan(rounded) ? isnan(value) : value == rounded;
  if (isfinite(rounded) && isfinite(value)) {
    const double error = errorOf(value, exact);
    worst = error > worst ? error : worst;
    isRight = error <= c->most && (value != 0 || rounded != 0 || !signbit(value) == !signbit(rounded));
  } else if (isinf(rounded) != isinf(value)) {
    /* At the edge of the range. */
    isRight = fabsf(isinf(rounded) ? value : rounded) >= FLT_MAX * (1 - 2 * FLT_EPSILON);
  }
  if (!isRight) {
    reportFailure("%s(%a) is %a, not %La\n", c->name, (double)x, (double)value, exact);
  }
}

static void checkSixteen(const Case* c, const float* x) {
  float value[16];
  functionOf(&portablePath, c)(x, value);
  for (int k = 0; k < 16; k++) {
    checkValue(c, x[k], value[k]);
  }
#ifdef __x86_64__
  const ElementaryPath* const others[] = {&avx2Path, &avx512Path};
  const bool isThere[] = {__builtin_cpu_supports("avx2") != 0,
                          __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0};
  for (int i = 0; i < 2; i++) {
    float other[16];
    if (isThere[i]) {
      functionOf(others[i], c)(x, other);
      for (int k = 0; k < 16; k++) {
        /* Not the bits of NaN, which stand for nothing. */
        if (memcmp(&other[k], &value[k], sizeof(float)) != 0 && !(isnan(other[k]) && isnan(value[k]))) {
          reportFailure("%s(%a) has other bits on instruction set %d\n", c->name, (double)x[k], i);
        }
      }
    }
  }
#endif
}

/* Each float of a row of neighbours around a number. */
static void checkAround(const Case* c, float x) {
  float row[64];
  for (int k = 0; k < 32; k++) {
    row[31 - k] = k == 0 ? x : nextafterf(row[32 - k], -INFINITY);
    row[32 + k] = nextafterf(k == 0 ? x : row[31 + k], INFINITY);
  }
  for (int k = 0; k < 64; k += 16) {
    checkSixteen(c, row + k);
  }
}

static float floatOf(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

int main(void) {
  const float special[] = {0,        -0.0f,    1,         -1,       0.5f,     2,       88.72284f,   89,
                           -87.336f, -103.97f, -104,      0.7071f,  1.41421f, 1000,    FLT_MIN,     -FLT_MIN,
                           FLT_MAX,  -FLT_MAX, 0x1p-149f, -1e-40f,  INFINITY, 3e-8f,   -6e-8f,      0x1p23f,
                           NAN,      10,       -10,       0.34657f, 1.0397f,  0x1p24f, 2.71828175f, -INFINITY};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    const Case* c = &cases[i];
    worst = 0;
    for (size_t k = 0; k < sizeof special / sizeof special[0]; k++) {
      checkAround(c, special[k]);
    }
    /* One float in some thousand. */
    float row[16];
    for (uint64_t bits = 0; bits < (uint64_t)1 << 32;) {
      for (int k = 0; k < 16; k++, bits += 4099) {
        row[k] = floatOf((uint32_t)bits);
      }
      checkSixteen(c, row);
    }
    /* Usual numbers more densely. */
    for (double x = -110; x < 110;) {
      for (int k = 0; k < 16; k++, x += 1.37e-4 * (1 + fabs(x))) {
        row[k] = (float)x;
      }
      checkSixteen(c, row);
    }
    printf("%s: at most %.3f units in the last place\n", c->name, worst);
  }
  return checkResult();
}
