// Where fuzzing starts from: inputs made by the tests' own builders, by target.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace furnace::fuzz {

using Seeds = std::map<std::string, std::vector<std::string>, std::less<>>;

// As an input's leading fields: little-endian.
inline std::string number(std::uint32_t value, std::size_t bytes) {
  std::string text;
  for (; bytes > 0; --bytes, value >>= 8) text += char(value);
  return text;
}

void add_image_seeds(Seeds& seeds);
void add_gltf_seeds(Seeds& seeds);
void add_mesh_seeds(Seeds& seeds);
void add_request_seeds(Seeds& seeds);

std::string file_text(std::string_view path);

}  // namespace furnace::fuzz
