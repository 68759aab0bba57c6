/* A table of the set bits of a byte: to write chosen numbers without gaps. */
#ifndef CT_RANKS_H_
#define CT_RANKS_H_

#include <stdint.h>

/* Per byte: the numbers of its set bits, ascending, and how many. */
typedef struct Ranks {
  uint8_t bit[256][8];
  uint8_t count[256];
} Ranks;

#endif /* CT_RANKS_H_ */
