#ifndef OPENMM_CHAINTREE_HEXADECIMAL_H_
#define OPENMM_CHAINTREE_HEXADECIMAL_H_

#include <string>

namespace ChainTreePlugin {

/**
 * Write bytes as text that an XML file can hold.
 */
inline std::string toHexadecimal(const std::string& bytes)
{
    static const char digits[] = "0123456789abcdef";
    std::string text;
    text.reserve(2 * bytes.size());
    for (unsigned char byte : bytes) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

/**
 * Read the result of toHexadecimal(). Returns false if the text is not hexadecimal.
 */
inline bool fromHexadecimal(const std::string& text, std::string& bytes)
{
    auto valueOf = [](char digit) {
        return digit >= '0' && digit <= '9' ? digit - '0' : digit >= 'a' && digit <= 'f' ? digit - 'a' + 10 : -1;
    };
    bytes.clear();
    bytes.reserve(text.size() / 2);
    for (size_t i = 0; i + 1 < text.size(); i += 2) {
        int high = valueOf(text[i]), low = valueOf(text[i + 1]);
        if (high < 0 || low < 0)
            return false;
        bytes += (char)(16 * high + low);
    }
    return text.size() % 2 == 0;
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_HEXADECIMAL_H_*/
