#include "renderer/decode/process_decoder.hpp"

#include <vector>

namespace furnace::decode {

PlainModel ProcessDecoder::model(std::span<const std::byte> document, std::string_view materials,
                                 ModelFormat format, const PlainModelLimits& limits,
                                 const Deadline& deadline) {
  const ModelJob job{format, document.size(), limits};
  if (materials.empty()) return run_in(pool_, job, document, deadline);
  std::vector<std::byte> file(document.begin(), document.end());
  const auto more = std::as_bytes(std::span(materials));
  file.insert(file.end(), more.begin(), more.end());
  return run_in(pool_, job, file, deadline);
}

}  // namespace furnace::decode
