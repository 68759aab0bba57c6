#include "randomSource.h"

#include <math.h>

/* Splitmix64. */
static uint64_t randomBits(randomSource* random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

randomSource randomSourceFromSeed(uint64_t seed)
{
    randomSource random = {.state = seed};
    random.state = randomBits(&random);
    return random;
}

randomSource randomSourceFromBytes(size_t count, const unsigned char* bytes)
{
    static const unsigned char none[1];
    randomSource random = randomSourceFromSeed(0);
    random.bytes = bytes != NULL ? bytes : none;
    random.byteCount = count;
    return random;
}

int randomIsUsedUp(const randomSource* random)
{
    return random->bytes != NULL && random->byteCount == 0;
}

/* At least 0 and below 1: from the given number of bytes if enough are left, else from all bits of a double. */
static double randomFraction(randomSource* random, size_t byteCount)
{
    if (random->byteCount < byteCount) {
        random->byteCount = 0;
        return (double)(randomBits(random) >> 11) * 0x1p-53;
    }
    double fraction = 0;
    for (size_t n = 0; n < byteCount; n++)
        fraction = (fraction + random->bytes[n]) / 256;
    random->bytes += byteCount;
    random->byteCount -= byteCount;
    return fraction;
}

int randomInt(randomSource* random, int count)
{
    return (int)(count * randomFraction(random, count <= 256 ? 1 : count <= 65536 ? 2 : 4));
}

double randomReal(randomSource* random, double low, double high)
{
    return low + (high - low) * randomFraction(random, 2);
}

int randomChance(randomSource* random, double probability)
{
    return randomFraction(random, 1) < probability;
}

void randomDirection(randomSource* random, double direction[3])
{
    double z = randomReal(random, -1, 1), angle = randomReal(random, -acos(-1), acos(-1)), flat = sqrt(1 - z * z);
    direction[0] = flat * cos(angle);
    direction[1] = flat * sin(angle);
    direction[2] = z;
}
