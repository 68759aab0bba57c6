/* operatororacle.h: operators of expressions in long double. */
#ifndef OPERATORORACLE_H_
#define OPERATORORACLE_H_

#include <math.h>
#include <stdlib.h>

#include "ctenergy.h"

/* How many results an operator takes. */
static inline int takes(ctOperator kind) {
  switch (kind) {
    case ctConstantOperator:
    case ctInputOperator:
    case ctParameterOperator:
      return 0;
    case ctAddOperator:
    case ctSubtractOperator:
    case ctMultiplyOperator:
    case ctDivideOperator:
    case ctPowerOperator:
    case ctAtan2Operator:
    case ctMinOperator:
    case ctMaxOperator:
      return 2;
    case ctSelectOperator:
    case ctImageLengthOperator:
      return 3;
    default:
      return 1; /* a table of one number, too */
  }
}

/* Of one that takes results, but no table. */
static inline long double oracleOperator(const ctOperation* o, long double a, long double b, long double c) {
  switch (o->kind) {
    case ctAddOperator:
      return a + b;
    case ctSubtractOperator:
      return a - b;
    case ctMultiplyOperator:
      return a * b;
    case ctDivideOperator:
      return a / b;
    case ctPowerOperator:
      return powl(a, b);
    case ctNegateOperator:
      return -a;
    case ctSqrtOperator:
      return sqrtl(a);
    case ctExpOperator:
      return expl(a);
    case ctLogOperator:
      return logl(a);
    case ctSinOperator:
      return sinl(a);
    case ctCosOperator:
      return cosl(a);
    case ctSecOperator:
      return 1 / cosl(a);
    case ctCscOperator:
      return 1 / sinl(a);
    case ctTanOperator:
      return tanl(a);
    case ctCotOperator:
      return 1 / tanl(a);
    case ctAsinOperator:
      return asinl(a);
    case ctAcosOperator:
      return acosl(a);
    case ctAtanOperator:
      return atanl(a);
    case ctAtan2Operator:
      return atan2l(a, b);
    case ctSinhOperator:
      return sinhl(a);
    case ctCoshOperator:
      return coshl(a);
    case ctTanhOperator:
      return tanhl(a);
    case ctErfOperator:
      return erfl(a);
    case ctErfcOperator:
      return erfcl(a);
    case ctStepOperator:
      return a < 0 ? 0 : 1;
    case ctDeltaOperator:
      return a == 0 ? 1 : 0;
    case ctSquareOperator:
      return powl(a, 2);
    case ctCubeOperator:
      return powl(a, 3);
    case ctReciprocalOperator:
      return 1 / a;
    case ctAddConstantOperator:
      return a + o->constant;
    case ctMultiplyConstantOperator:
      return a * o->constant;
    case ctPowerConstantOperator:
      return powl(a, o->constant);
    case ctMinOperator:
      return fminl(a, b);
    case ctMaxOperator:
      return fmaxl(a, b);
    case ctAbsOperator:
      return fabsl(a);
    case ctFloorOperator:
      return floorl(a);
    case ctCeilOperator:
      return ceill(a);
    case ctSelectOperator:
      return a != 0 ? b : c;
    case ctImageLengthOperator: /* without a box */
      return sqrtl(a * a + b * b + c * c);
    case ctConstantOperator:
    case ctInputOperator:
    case ctParameterOperator:
    case ctTableOperator:
      break;
  }
  abort();
}

#endif /* OPERATORORACLE_H_ */
