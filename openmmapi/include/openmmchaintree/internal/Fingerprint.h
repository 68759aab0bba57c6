#ifndef OPENMM_CHAINTREE_FINGERPRINT_H_
#define OPENMM_CHAINTREE_FINGERPRINT_H_

#include <cstddef>
#include <cstdint>
#include <string>

namespace ChainTreePlugin {

/**
 * Get a text that tells bytes from others (FNV-1a).
 */
inline std::string fingerprint(const void* data, std::size_t size)
{
    std::uint64_t hash = 0xcbf29ce484222325;
    const unsigned char* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3;
    return std::to_string(hash);
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FINGERPRINT_H_*/
