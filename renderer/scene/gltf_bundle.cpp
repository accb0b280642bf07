// What belongs to a glTF file beside itself.
#include <set>

#include "renderer/scene/gltf_container.hpp"
#include "renderer/scene/gltf_document.hpp"
#include "renderer/scene/gltf_import.hpp"

namespace furnace {

namespace {

// Appends the decoded URI of one buffer or image, unless it is a data: one or known.
void add_external_uri(const std::string& uri, const std::string& pointer, std::set<std::string>& seen,
                      std::vector<std::string>& uris) {
  if (is_data_uri(uri)) return;
  std::string path = decode_relative_uri(uri, pointer);
  if (seen.insert(path).second) uris.push_back(std::move(path));
}

}  // namespace

void ModelBundle::seal() {
  HashBuilder builder;
  builder.add(document.hash());
  if (format != ModelFormat::kGltf) builder.add(std::int64_t(format));
  for (const auto& [uri, blob] : siblings) builder.add(uri).add(blob.hash());
  hash = builder.finish();
}

std::vector<std::string> gltf_external_uris(const Blob& bytes, const ImportLimits& limits) {
  const GltfDocument document = read_gltf_document(bytes, limits);
  std::set<std::string> seen;
  std::vector<std::string> uris;
  for (std::size_t i = 0; i < document.buffers.size(); ++i) {
    const GltfBuffer& buffer = document.buffers[i];
    if (buffer.has_uri && !buffer.is_fallback)
      add_external_uri(buffer.uri, "/buffers/" + std::to_string(i) + "/uri", seen, uris);
  }
  for (std::size_t i = 0; i < document.images.size(); ++i) {
    const GltfImage& image = document.images[i];
    if (!image.buffer_view) add_external_uri(image.uri, "/images/" + std::to_string(i) + "/uri", seen, uris);
  }
  return uris;
}

}  // namespace furnace
