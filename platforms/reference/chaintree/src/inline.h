#ifndef CT_INLINE_H_
#define CT_INLINE_H_

/* Functions that vectors go into, or constants: a call would hand them over by way of memory. */
#define CT_INLINE static inline __attribute__((always_inline))

#endif /* CT_INLINE_H_ */
