/* Sines, cosines and whole turns, which the engine computes without the C library, against long doubles. */
#include "../src/transform.h"
#include "check.h"

enum { ANGLES = 200000 };

static uint32_t state = 1;

/* From -1 to 1, of 48 bits. */
static double drawn(void) {
  double x = 0;
  for (int i = 0; i < 2; i++) {
    state = state * 1664525u + 1013904223u;
    x = x * 0x1p24 + (state >> 8);
  }
  return x * 0x1p-47 - 1;
}

/* Errors in units of the last place, but none where they are below 1e-20. */
static double errorOf(double x, long double exact) {
  int exponent;
  frexp((double)exact, &exponent);
  return (double)(fabsl((long double)x - exact) / (long double)larger(ldexp(1, exponent - 53), 1e-20));
}

/* Tests an angle; returns the larger error. */
static double testAngle(double x) {
  const Angle angle = angleOfAny(x);
  const Angle opposite = angleOfAny(-x);
  CHECK(opposite.sine == -angle.sine && opposite.cosine == angle.cosine);
  CHECK(signbit(opposite.sine) != signbit(angle.sine));
  CHECK(fabs(angle.sine) <= 1 && fabs(angle.cosine) <= 1);
  if (fabs(x) <= CT_EXACT_ANGLE) {
    /* Small ones take another way. */
    const Angle byQuarters = angleOf(x);
    CHECK(byQuarters.sine == angle.sine && byQuarters.cosine == angle.cosine);
    const double within = withoutTurns(x);
    CHECK(fabs(within) <= 3.14159265358979324 + 1e-9);
    CHECK(fabsl(sinl((long double)within) - sinl((long double)x)) < 5e-16L);
    CHECK(fabsl(cosl((long double)within) - cosl((long double)x)) < 5e-16L);
  }
  return larger(errorOf(angle.sine, sinl((long double)x)), errorOf(angle.cosine, cosl((long double)x)));
}

static void testRanges(void) {
  static const double ranges[] = {1e-300, 1e-9, 0.78, 1, 3.2, 7, 1000, CT_EXACT_ANGLE, 1e9, 1e300};
  for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
    double worst = 0;
    for (int k = 0; k < ANGLES; k++) {
      worst = larger(worst, testAngle(ranges[i] * drawn()));
    }
    printf("up to %g: errors of at most %.3f units\n", ranges[i], worst);
    CHECK(worst < 1.6);
  }
}

/* Next to quarters of a turn, where sine or cosine is small, and halfway, where the nearest quarter changes. */
static void testQuarters(void) {
  double worst = 0;
  for (int n = 0; n < 4000; n++) {
    const int eighths = n < 2000 ? n : n * 300 + (int)(100 * drawn());
    double x = (double)(eighths * 0.785398163397448309616L);
    for (int step = 0; step < 5; step++) {
      worst = larger(worst, testAngle(x));
      x = nextafter(x, INFINITY);
    }
  }
  printf("at eighths of a turn: errors of at most %.3f units\n", worst);
  CHECK(worst < 1.6);
  CHECK(angleOfAny(0).sine == 0 && angleOfAny(0).cosine == 1);
}

int main(void) {
  testRanges();
  testQuarters();
  return checkResult();
}
