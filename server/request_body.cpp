#include "server/request_body.hpp"

#include <algorithm>
#include <ranges>
#include <set>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "server/multipart.hpp"
#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::string_view kRequestPart = "request";

// A file is found under its part's name and its own name; a part name given twice (a form's multiple files)
// under neither.
std::map<std::string, Blob> named_files(const std::vector<Part>& parts) {
  std::map<std::string, Blob> files;
  std::map<std::string, int> uses;
  for (const Part& part : parts) ++uses[part.head.name];
  std::set<std::string> file_names;
  for (const Part& part : parts) {
    if (part.head.name == kRequestPart) continue;
    const Blob blob{std::string(part.body)};
    if (!part.head.file_name.empty() && !file_names.insert(part.head.file_name).second) {
      fail(ErrorCode::kInvalidRequest,
           fmt::format("Two parts have the file name {}.", api::quoted(part.head.file_name)));
    }
    if (uses[part.head.name] == 1) files[part.head.name] = blob;
    if (!part.head.file_name.empty()) files.emplace(part.head.file_name, blob);
  }
  return files;
}

RequestBody read_multipart(const Request& request, int max_parts) {
  RequestBody body;
  const std::vector<Part> parts = parse_multipart(request.body, request.header("Content-Type"), max_parts);
  const auto is_document = [](const Part& part) { return part.head.name == kRequestPart; };
  const auto documents = std::ranges::count_if(parts, is_document);
  if (documents > 1) fail(ErrorCode::kInvalidRequest, "There is more than one part named request.");
  if (documents == 1) body.document = std::ranges::find_if(parts, is_document)->body;
  body.parts = named_files(parts);
  return body;
}

}  // namespace

RequestBody read_body(const Request& request, int max_parts) {
  const std::string type = media_type_essence(request.header("Content-Type"));
  if (type == "multipart/form-data") return read_multipart(request, max_parts);
  if (type.empty() && request.body.empty()) return {};
  if (type != "application/json") {
    fail(ErrorCode::kUnsupportedMedia,
         "Send the request as Content-Type: application/json, or as multipart/form-data with a part named "
         "request.");
  }
  return {request.body, {}};
}

}  // namespace furnace
