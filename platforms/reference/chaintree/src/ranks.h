/* How bits that are set close ranks. */
#ifndef CT_RANKS_H_
#define CT_RANKS_H_

#include <stdint.h>

/* Per byte the numbers of its bits, ascending, and how many they are. */
typedef struct Ranks {
  uint8_t bit[256][8];
  uint8_t count[256];
} Ranks;

#endif /* CT_RANKS_H_ */
