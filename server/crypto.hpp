// What keys and signatures need of libcrypto.
#pragma once

#include <string>
#include <string_view>

namespace furnace {

std::string hmac_sha256(std::string_view secret, std::string_view text);  // 32 bytes; RFC 2104

// Takes as long whatever differs; only whether the lengths do may show.
bool equal_in_constant_time(std::string_view a, std::string_view b);

// For keys, from the operating system; no picture depends on it. Errors: kInternal.
std::string random_bytes(int count);

}  // namespace furnace
