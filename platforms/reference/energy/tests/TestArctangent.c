/* The own arctangent against the C library's in long double: on the whole circle, for all magnitudes, at the edges of
 * its cases, and where C defines the value. */
#include <float.h>
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "../../simd/arctangent.h"

static double most = 0; /* error so far, in units in the last place */

static uint64_t chance = 88172645463325252u;

static double draw(void) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (double)(chance >> 11) * 0x1p-53;
}

static void checkAngle(double y, double x) {
  const long double expected = atan2l(y, x);
  const double angle = arctangent2(y, x);
  int exponent;
  frexp((double)expected, &exponent);
  const double unit = ldexp(1, exponent - DBL_MANT_DIG > -1074 ? exponent - DBL_MANT_DIG : -1074);
  const double error = (double)(fabsl(angle - expected) / unit);
  if (!(error <= 2)) {
    reportFailure("arctangent2(%a, %a) is off by %g units\n", y, x, error);
  }
  most = error > most ? error : most;
}

static void checkAllSigns(double y, double x) {
  checkAngle(y, x);
  checkAngle(-y, x);
  checkAngle(y, -x);
  checkAngle(-y, -x);
  checkAngle(x, y);
  checkAngle(-x, y);
}

static void checkSame(double y, double x) {
  const double angle = arctangent2(y, x);
  const double expected = atan2(y, x);
  CHECK(isnan(expected) ? isnan(angle) : fabs(angle - expected) <= 4e-16 && !signbit(angle) == !signbit(expected));
}

int main(void) {
  for (int i = 0; i < 400000; i++) {
    const double angle = 2 * PI * draw();
    const double length = ldexp(1 + draw(), (int)(600 * draw()) - 300);
    checkAngle(length * sin(angle), length * cos(angle));
    /* Near the axes and the diagonals. */
    const double little = ldexp(draw(), -(int)(70 * draw()));
    checkAllSigns(little, 1 + draw());
    checkAllSigns(1 + little, 1);
    checkAllSigns(draw(), draw());
  }
  /* Where one case ends and the next begins. */
  for (int k = 1; k <= 64; k++) {
    double t = k / 64.0;
    for (int step = 0; step < 20; step++) {
      t = nextafter(t, 0);
    }
    for (int step = 0; step < 40; step++) {
      checkAllSigns(t, 1);
      t = nextafter(t, 2);
    }
  }
  checkAllSigns(DBL_MIN, 1);
  checkAllSigns(4 * DBL_TRUE_MIN, 3);
  checkAllSigns(DBL_MAX, DBL_MIN);
  checkAllSigns(DBL_MAX, DBL_MAX);
  checkAllSigns(DBL_TRUE_MIN, DBL_TRUE_MIN);
  const double odd[] = {0.0, -0.0, 1, -1, DBL_MAX, -DBL_MAX, INFINITY, -INFINITY, NAN};
  for (int i = 0; i < 9; i++) {
    for (int k = 0; k < 9; k++) {
      checkSame(odd[i], odd[k]);
    }
  }
  printf("at most %.3f units in the last place\n", most);
  return checkResult();
}
