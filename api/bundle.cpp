#include "api/bundle.hpp"

#include <cctype>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/base/error.hpp"

namespace furnace::api {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kKind = "furnace-bundle-1";

// What of a reference a person recognises, and its ending, from which a model's format may be told.
std::string plain_name(std::string_view reference) {
  constexpr std::size_t kMostBytes = 80;
  std::string_view last = reference.substr(reference.find_last_of("/:") + 1);
  if (last.size() > kMostBytes) last.remove_prefix(last.size() - kMostBytes);
  std::string name;
  for (const char c : last) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
    name += is_plain ? c : '_';
  }
  return name;
}

class Packer {
 public:
  explicit Packer(std::string_view document) : json_(Json::parse(document)) {}

  void add(const ReadReference& read) {
    if (read.reference.starts_with("data:")) return;
    const Json::json_pointer place(read.pointer);
    if (!read.model) {
      // A model's files are told once, all of them, with the model.
      if (!read.pointer.starts_with("/scene/files/")) json_[place] = part(read.file, read.reference);
      return;
    }
    json_[place] = part(read.model->document, read.reference);
    Json files = Json::object();
    for (const auto& [name, file] : read.model->siblings) files[name] = part(file, name);
    Json& scene = json_[place.parent_pointer()];
    scene.erase("files");
    if (!files.empty()) scene["files"] = std::move(files);
  }

  SelfContained finish(const OutputSpec& output) && {
    json_["output"]["format"] = name_of(output.format);
    return {json_.dump(2), std::move(parts_)};
  }

 private:
  std::string part(const Blob& file, std::string_view reference) {
    const auto [known, is_new] = names_.try_emplace(file.hash());
    if (is_new) {
      known->second = fmt::format("{}-{}", names_.size(), plain_name(reference));
      parts_.emplace(known->second, file);
    }
    return "part:" + known->second;
  }

  Json json_;
  std::map<std::string, Blob> parts_;
  std::map<ContentHash, std::string> names_;
};

}  // namespace

SelfContained self_contained(std::string_view document, const std::vector<ReadReference>& reads,
                             const OutputSpec& output) {
  Packer packer(document);
  for (const ReadReference& read : reads) packer.add(read);
  return std::move(packer).finish(output);
}

std::string bundle_json(const BundleAbout& about) {
  return Json{{"kind", kKind},
              {"fingerprint", about.fingerprint},
              {"determinism", about.is_exact ? "exact" : "fast"},
              {"etag", about.etag},
              {"picture", about.picture},
              {"sha256", about.sha256}}
      .dump(2);
}

BundleAbout parse_bundle_json(std::string_view json) {
  const Json read = Json::parse(json, nullptr, false);
  const auto text = [&](const char* key) {
    const auto found = read.find(key);
    return found != read.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (!read.is_object() || text("kind") != kKind)
    fail(ErrorCode::kUnprocessable, "bundle.json is not of a bundle that this version reads");
  return {text("fingerprint"), text("determinism") == "exact", text("etag"), text("picture"), text("sha256")};
}

}  // namespace furnace::api
