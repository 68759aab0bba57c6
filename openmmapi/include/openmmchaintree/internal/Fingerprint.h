#ifndef OPENMM_CHAINTREE_FINGERPRINT_H_
#define OPENMM_CHAINTREE_FINGERPRINT_H_

#include <cstddef>
#include <cstdint>
#include <string>

namespace ChainTreePlugin {

/**
 * Get a checksum of bytes (FNV-1a). It changes with every single byte.
 */
inline std::uint64_t hashBytes(const void* data, std::size_t size)
{
    std::uint64_t hash = 0xcbf29ce484222325;
    const unsigned char* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3;
    return hash;
}

/**
 * The same as a text.
 */
inline std::string fingerprint(const void* data, std::size_t size)
{
    return std::to_string(hashBytes(data, size));
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FINGERPRINT_H_*/
