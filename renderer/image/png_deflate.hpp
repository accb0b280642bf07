// A compressor for the filtered rows of rendered pictures, in the format of zlib.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace furnace {

// Appends `bytes` as a zlib stream (RFC 1950) of dynamic Huffman blocks (RFC 1951) whose only matches are runs of one byte. The
// noise of a render has no others worth finding: without the search this takes a third of the time of libdeflate's fastest
// level, for files of the same size. Same bytes, same stream.
void append_run_deflated(std::span<const std::uint8_t> bytes, std::string& out);

}  // namespace furnace
