#ifndef CT_INLINE_H_
#define CT_INLINE_H_

/* For functions with vectors or constants as arguments: a call would pass these through memory. */
#define CT_INLINE static inline __attribute__((always_inline))

/* For functions that are seldom called: without their code their callers have more registers, and are quicker. */
#define CT_NOINLINE static __attribute__((noinline))

#endif /* CT_INLINE_H_ */
