#include "api/stored_render.hpp"

#include <span>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"

namespace furnace::api {

namespace {

using Json = nlohmann::json;

// Checksum of what follows it, a line of JSON, the picture's bytes.
constexpr std::size_t kChecksumDigits = 64;

[[noreturn]] void refuse(std::string detail) {
  fail(ErrorCode::kUnprocessable, "a stored render is damaged", {}, std::move(detail));
}

std::string checksum(std::string_view text) {
  return hash_bytes(std::as_bytes(std::span(text))).hex();
}

}  // namespace

std::string encode_stored_render(const StoredRender& render) {
  Json notes = Json::array();
  for (const Note& note : render.notes) notes.push_back({note.code, note.pointer, note.message});
  const Json about = {{"mediaType", render.media_type},
                      {"exposureEv", render.exposure_ev},
                      {"frames", render.frames},
                      {"notes", std::move(notes)},
                      {"report", render.report}};
  const std::string content =
      about.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n" + render.bytes;
  return checksum(content) + "\n" + content;
}

StoredRender decode_stored_render(const std::string& file) {
  const std::string_view text = file;
  if (text.size() <= kChecksumDigits || text[kChecksumDigits] != '\n') refuse("no checksum");
  const std::string_view content = text.substr(kChecksumDigits + 1);
  if (checksum(content) != text.substr(0, kChecksumDigits)) refuse("its checksum is another");
  const std::size_t line = content.find('\n');
  if (line == content.npos) refuse("no line about the picture");
  try {
    const Json about = Json::parse(content.substr(0, line));
    StoredRender render{std::string(content.substr(line + 1)),
                        about.at("mediaType").get<std::string>(),
                        about.at("exposureEv").get<double>(),
                        about.at("frames").get<int>(),
                        {},
                        about.at("report").get<std::string>()};
    for (const Json& note : about.at("notes"))
      render.notes.push_back(
          {note.at(0).get<std::string>(), note.at(1).get<std::string>(), note.at(2).get<std::string>()});
    return render;
  } catch (const Json::exception& error) {
    refuse(error.what());
  }
}

}  // namespace furnace::api
