// What still and animated PNG files are made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/image/encode.hpp"

namespace furnace {

void append_big_endian(std::string& out, std::uint32_t value);
void append_big_endian16(std::string& out, std::uint32_t value);

// Of a chunk's name and content.
std::uint32_t png_checksum(std::span<const std::byte> bytes);

// A chunk begins with begin_chunk, whose result end_chunk takes once its content is appended: it writes length and checksum.
std::size_t begin_chunk(std::string& out, std::string_view type);
void end_chunk(std::string& out, std::size_t start);

// Signature, IHDR, what says that it is sRGB. kUint8 or kUint16.
void append_png_head(std::string& out, const Image& image);
void append_png_text(std::string& out, const std::vector<TextField>& metadata);
// The rows, filtered and compressed: content of IDAT or fdAT.
void append_png_rows(std::string& out, const Image& image);
void append_png_end(std::string& out);

}  // namespace furnace
