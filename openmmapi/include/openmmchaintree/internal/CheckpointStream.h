#ifndef OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_
#define OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_

#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/Fingerprint.h"
#include <algorithm>
#include <cstdint>
#include <istream>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace ChainTreePlugin {

/**
 * Writes to a checkpoint: values as they are in memory, vectors with their length in front. Throws an OpenMMException
 * if the stream fails.
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
        writeBytes(&value, sizeof(T));
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
        writeBytes(bytes.data(), bytes.size());
    }
    /**
     * Write bytes with their length and checksum in front.
     */
    void writeSealed(const std::string& bytes)
    {
        write((uint64_t)bytes.size());
        write(hashBytes(bytes.data(), bytes.size()));
        append(bytes);
    }

private:
    void writeBytes(const void* bytes, std::size_t size)
    {
        stream.write(static_cast<const char*>(bytes), size);
        if (!stream)
            throw OpenMM::OpenMMException("createCheckpoint: the checkpoint could not be written");
    }
    std::ostream& stream;
};

/**
 * Reads the output of a CheckpointWriter. Throws an OpenMMException if the stream ends too early, or if sealed bytes
 * have changed.
 */
class CheckpointReader {
public:
    explicit CheckpointReader(std::istream& stream) : stream(stream)
    {
    }
    template <class T>
    T read()
    {
        static_assert(std::is_trivially_copyable<T>::value, "only what has no pointers can be read as it is");
        T value;
        readBytes(&value, sizeof(T));
        return value;
    }
    template <class T>
    std::vector<T> readVector()
    {
        return readMany<std::vector<T>>(read<uint64_t>());
    }
    std::string readString()
    {
        return readMany<std::string>(read<uint64_t>());
    }
    /**
     * Read the result of writeSealed().
     */
    std::string readSealed()
    {
        const uint64_t size = read<uint64_t>(), hash = read<uint64_t>();
        const std::string bytes = readMany<std::string>(size);
        if (hashBytes(bytes.data(), bytes.size()) != hash)
            throw OpenMM::OpenMMException("loadCheckpoint: the checkpoint is damaged");
        return bytes;
    }

private:
    void readBytes(void* bytes, std::size_t size)
    {
        stream.read(static_cast<char*>(bytes), size);
        if (!stream)
            throw OpenMM::OpenMMException("loadCheckpoint: the checkpoint is incomplete");
    }
    /**
     * Read values in chunks, so that a damaged length does not cause a huge allocation.
     */
    template <class Values>
    Values readMany(uint64_t length)
    {
        const uint64_t most = 1 << 16;
        Values values;
        while (values.size() < length) {
            const std::size_t begin = values.size(), count = std::min(length - begin, most);
            values.resize(begin + count);
            readBytes(&values[begin], count * sizeof(typename Values::value_type));
        }
        return values;
    }
    std::istream& stream;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CHECKPOINTSTREAM_H_*/
