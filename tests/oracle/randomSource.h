/* randomSource.h: where random choices come from: a seed, or bytes that somebody else has chosen.
 *
 * A fuzzer chooses bytes. Each choice takes as few of them as it can do with, so that a change of one byte is a change
 * of one choice.
 */
#ifndef RANDOM_SOURCE_H_
#define RANDOM_SOURCE_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct randomSource {
    uint64_t state;
    const unsigned char* bytes; /* used before numbers from the state, or NULL */
    size_t byteCount;           /* number of unused bytes */
} randomSource;

randomSource randomSourceFromSeed(uint64_t seed);

/* The bytes stay the caller's. After the last byte, choices follow from a seed. */
randomSource randomSourceFromBytes(size_t count, const unsigned char* bytes);

/* Whether choices came from bytes, and these are used up. */
int randomIsUsedUp(const randomSource* random);

/* An integer from 0 to count - 1. */
int randomInt(randomSource* random, int count);

/* A number from low to high. */
double randomReal(randomSource* random, double low, double high);

int randomChance(randomSource* random, double probability);

/* Writes a direction, uniform on the unit sphere. */
void randomDirection(randomSource* random, double direction[3]);

#ifdef __cplusplus
}
#endif

#endif /* RANDOM_SOURCE_H_ */
