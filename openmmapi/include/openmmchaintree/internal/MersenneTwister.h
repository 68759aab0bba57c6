#ifndef OPENMM_CHAINTREE_MERSENNETWISTER_H_
#define OPENMM_CHAINTREE_MERSENNETWISTER_H_

#include <cstdint>
#include <istream>
#include <ostream>

namespace ChainTreePlugin {

/**
 * The numbers of std::mt19937_64, in less time: the loops of GCC's library take a branch that depends on a random bit,
 * which processors mispredict every other time. The text in a stream is the same as GCC's library writes.
 */
class MersenneTwister {
public:
    explicit MersenneTwister(uint64_t seed) : next(SIZE)
    {
        words[0] = seed;
        for (int i = 1; i < SIZE; i++)
            words[i] = 6364136223846793005ull * (words[i - 1] ^ words[i - 1] >> 62) + i;
    }
    uint64_t operator()()
    {
        if (next == SIZE)
            makeWords();
        uint64_t word = words[next++];
        word ^= word >> 29 & 0x5555555555555555ull;
        word ^= word << 17 & 0x71d67fffeda60000ull;
        word ^= word << 37 & 0xfff7eee000000000ull;
        return word ^ word >> 43;
    }
    /**
     * Write the state, which determines all further numbers.
     */
    void write(std::ostream& stream) const
    {
        for (uint64_t word : words)
            stream << word << ' ';
        stream << next;
    }
    /**
     * Read the result of write(). Returns false, and changes nothing, if it is damaged.
     */
    bool read(std::istream& stream)
    {
        MersenneTwister restored(0);
        for (uint64_t& word : restored.words)
            stream >> word;
        stream >> restored.next;
        if (!stream || restored.next < 0 || restored.next > SIZE)
            return false;
        *this = restored;
        return true;
    }

private:
    static const int SIZE = 312, SHIFT = 156;
    static uint64_t twist(uint64_t first, uint64_t second, uint64_t other)
    {
        const uint64_t word = (first & 0xffffffff80000000ull) | (second & 0x7fffffffull);
        return other ^ word >> 1 ^ ((0 - (word & 1)) & 0xb5026f5aa96619e9ull);
    }
    void makeWords()
    {
        for (int i = 0; i < SIZE - SHIFT; i++)
            words[i] = twist(words[i], words[i + 1], words[i + SHIFT]);
        for (int i = SIZE - SHIFT; i < SIZE - 1; i++)
            words[i] = twist(words[i], words[i + 1], words[i + SHIFT - SIZE]);
        words[SIZE - 1] = twist(words[SIZE - 1], words[0], words[SHIFT - 1]);
        next = 0;
    }
    uint64_t words[SIZE];
    /** The word that is drawn next; SIZE if all have been. */
    int next;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_MERSENNETWISTER_H_*/
