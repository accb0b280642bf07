#include "server/http_translation.hpp"

#include <utility>

namespace furnace {

std::map<std::string, std::string, HeaderLess> joined_headers(const httplib::Headers& headers) {
  std::map<std::string, std::string, HeaderLess> out;
  for (const auto& [name, value] : headers) {
    std::string& joined = out[name];
    if (!joined.empty()) joined.append(", ");
    joined.append(value);
  }
  // The library puts addresses among the headers.
  for (const char* added : {"REMOTE_ADDR", "REMOTE_PORT", "LOCAL_ADDR", "LOCAL_PORT"}) out.erase(added);
  return out;
}

void fill(httplib::Response& out, Reply reply) {
  out.status = reply.status;
  for (const auto& [name, value] : reply.headers) out.set_header(name, value);
  if (reply.stream) {
    out.set_chunked_content_provider(reply.media_type,
                                     [next = std::move(reply.stream)](size_t, httplib::DataSink& sink) {
                                       std::string piece;
                                       const bool more = next(piece);
                                       if (!piece.empty() && !sink.write(piece.data(), piece.size()))
                                         return false;
                                       if (!more) sink.done();
                                       return true;
                                     });
    return;
  }
  if (reply.file) {
    const ByteRange sent = reply.part.value_or(ByteRange{0, reply.file->bytes});
    out.set_content_provider(static_cast<size_t>(sent.size()), reply.media_type,
                             [file = reply.file, first = static_cast<size_t>(sent.first)](
                                 size_t offset, size_t length, httplib::DataSink& sink) {
                               const std::string piece = file->read(first + offset, length);
                               return !piece.empty() && sink.write(piece.data(), piece.size());
                             });
    return;
  }
  out.body = std::move(reply.body);
  if (reply.part) out.body = out.body.substr(std::size_t(reply.part->first), std::size_t(reply.part->size()));
  if (!reply.media_type.empty()) out.set_header("Content-Type", reply.media_type);
}

}  // namespace furnace
