// Animations pose a document: what a clip says at a time is written into its JSON, as if the file had said so, and read
// like everything else. So whatever an animation may move is checked and understood in one place.
#pragma once

#include <vector>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/gltf_read.hpp"

namespace furnace {

// Reads keyframes, and counts them: any number of samplers may share an accessor, so a small file can ask for any amount.
// Threads: one. Owns: nothing.
class KeyframeReader {
 public:
  KeyframeReader(const GltfData& data, const ImportLimits& limits, const Deadline& deadline)
      : data_(data), limits_(limits), deadline_(deadline) {}

  const GltfAccessor& accessor(int index) const { return data_.accessor(index); }
  // As GltfData::read_numbers. Errors: kTooLarge at `pointer`, kDeadlineExceeded.
  std::vector<float> read(int accessor, const std::string& pointer);

 private:
  const GltfData& data_;
  const ImportLimits& limits_;
  const Deadline& deadline_;
  std::uint64_t numbers_ = 0;
};

// Every animation of the document, with its length. One that cannot be played becomes a note.
std::vector<SceneAnimation> list_animations(const GltfDocument& document, KeyframeReader& keyframes,
                                            GltfNotes& notes);

// The document's animation that a request means; none: there is no such.
std::optional<int> find_animation(const GltfDocument& document, const std::variant<int, std::string>& which);

// Writes the clip's values into `root`, which is the document's. Channels that move nothing that is known become notes.
// Errors: kUnprocessable with a pointer for keyframes that are damaged.
void pose_document(Json& root, const GltfDocument& document, KeyframeReader& keyframes, int animation,
                   const AnimationTime& time, GltfNotes& notes);

}  // namespace furnace
