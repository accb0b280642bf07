// What wraps a glTF's JSON and its bytes: the GLB container, relative URIs and data: URIs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/base/blob.hpp"

namespace furnace {

struct ByteRange {
  std::size_t offset = 0;
  std::size_t size = 0;
};

struct GltfContainer {
  ByteRange json;
  std::optional<ByteRange> binary;  // a GLB's BIN chunk
};

// A GLB by its magic, else the whole is JSON. Errors: kUnprocessable, with the byte offset of the fault.
GltfContainer open_gltf_container(const Blob& document);

bool is_data_uri(std::string_view uri);

// The percent-decoded relative path. Errors: kUnprocessable for a scheme, an absolute path, "..", control
// characters or a broken escape.
std::string decode_relative_uri(std::string_view uri, const std::string& pointer);

// The bytes of a "data:" URI: strict base64 (RFC 4648, section 4, padded) or percent-encoded. Errors:
// kUnprocessable.
std::string decode_data_uri(std::string_view uri, const std::string& pointer);

// At most about `max_bytes` of a text of the document, for messages and reports; never cuts a character of UTF-8.
std::string shortened(std::string_view text, std::size_t max_bytes = 100);

}  // namespace furnace
