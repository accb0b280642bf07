// Models that are no glTF as scenes, from texts.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/scene/model_import.hpp"

namespace furnace::test {

using Siblings = std::map<std::string, std::string>;

inline ModelBundle bundle_of(const std::string& document, const Siblings& siblings = {}) {
  ModelBundle bundle;
  bundle.document = Blob(document);
  bundle.format = model_format(bundle.document, "");
  for (const auto& [name, bytes] : siblings) bundle.siblings.emplace(name, Blob(bytes));
  bundle.seal();
  return bundle;
}

inline Scene import_text(const std::string& document, const Siblings& siblings = {},
                         std::optional<UpAxis> up = {}, const ImportLimits& limits = {}) {
  return import_model(bundle_of(document, siblings), up, limits, decode::in_process_decoder(), Deadline());
}

inline Error error_of(const std::string& document, const ImportLimits& limits = {}) {
  try {
    import_text(document, {}, {}, limits);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

inline bool has_note(const Scene& scene, std::string_view code) {
  return std::ranges::any_of(scene.notes, [&](const Note& note) { return note.code == code; });
}

}  // namespace furnace::test
