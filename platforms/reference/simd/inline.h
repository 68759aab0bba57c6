#ifndef CT_INLINE_H_
#define CT_INLINE_H_

/* For functions with vectors or constants as arguments: a call would pass these through memory. */
#define CT_INLINE static inline __attribute__((always_inline))

#endif /* CT_INLINE_H_ */
