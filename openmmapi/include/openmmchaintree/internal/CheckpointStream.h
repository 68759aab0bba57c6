#ifndef OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_
#define OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_

#include "openmm/OpenMMException.h"
#include <algorithm>
#include <cstdint>
#include <istream>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class writes to a checkpoint: values as they are in memory, vectors of them with their length in front.
 */
class CheckpointWriter {
public:
    explicit CheckpointWriter(std::ostream& stream) : stream(stream)
    {
    }
    template <class T>
    void write(const T& value)
    {
        static_assert(std::is_trivially_copyable<T>::value, "only what has no pointers can be written as it is");
        stream.write(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    template <class T>
    void write(const std::vector<T>& values)
    {
        write((uint64_t)values.size());
        for (const T& value : values)
            write(value);
    }
    void write(const std::string& text)
    {
        write(std::vector<char>(text.begin(), text.end()));
    }
    /**
     * Write bytes that another CheckpointWriter made, without their length.
     */
    void append(const std::string& bytes)
    {
        stream.write(bytes.data(), bytes.size());
    }

private:
    std::ostream& stream;
};

/**
 * This class reads from a checkpoint what a CheckpointWriter has written. It throws an OpenMMException at the end.
 */
class CheckpointReader {
public:
    explicit CheckpointReader(std::istream& stream) : stream(stream)
    {
    }
    template <class T>
    T read()
    {
        T value;
        stream.read(reinterpret_cast<char*>(&value), sizeof(T));
        if (!stream)
            throw OpenMM::OpenMMException("loadCheckpoint: the checkpoint is incomplete");
        return value;
    }
    template <class T>
    std::vector<T> readVector()
    {
        // A length from a damaged file must not decide how much memory to ask for.

        uint64_t length = read<uint64_t>();
        std::vector<T> values;
        values.reserve(std::min<uint64_t>(length, 1 << 16));
        for (uint64_t i = 0; i < length; i++)
            values.push_back(read<T>());
        return values;
    }
    std::string readString()
    {
        std::vector<char> text = readVector<char>();
        return std::string(text.begin(), text.end());
    }

private:
    std::istream& stream;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_*/
