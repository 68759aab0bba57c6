/* switching.h for sixteen distances. */
#ifndef CT_SWITCHING16_H_
#define CT_SWITCHING16_H_

#include "simd.h"

CT_INLINE Float16 switchFactor16(Float16 distance, float switchingDistance, float inverseWidth) {
  const Float16 t = mul16(max16(sub16(distance, all16(switchingDistance)), all16(0)), all16(inverseWidth));
  const Float16 cubic = mul16(mul16(t, t), t);
  const Float16 inner = sub16(mul16(t, sub16(all16(15), mul16(t, all16(6)))), all16(10));
  return add16(all16(1), mul16(cubic, inner));
}

#endif /* CT_SWITCHING16_H_ */
