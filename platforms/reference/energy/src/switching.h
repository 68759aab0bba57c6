/* The switch that multiplies an energy from its switching distance to its cutoff; see ctNonbonded. */
#ifndef CT_SWITCHING_H_
#define CT_SWITCHING_H_

/* t is 0 at the switching distance, and 1 at the cutoff. */
static inline double switchFactor(double t) {
  return 1 + t * t * t * (-10 + t * (15 - t * 6));
}

#endif /* CT_SWITCHING_H_ */
