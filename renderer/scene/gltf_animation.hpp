// Animations pose a document: what a clip says at a time is written into its JSON, as if the file had said so, and read
// like everything else. So whatever an animation may move is checked and understood in one place.
#pragma once

#include <vector>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/gltf_read.hpp"

namespace furnace {

// Every animation of the document, with its length. One that cannot be played becomes a note.
std::vector<SceneAnimation> list_animations(const GltfDocument& document, const GltfData& data,
                                            GltfNotes& notes);

// The document's animation that a request means; none: there is no such.
std::optional<int> find_animation(const GltfDocument& document, const std::variant<int, std::string>& which);

// Writes the clip's values into `root`, which is the document's. Channels that move nothing that is known become notes.
// Errors: kUnprocessable with a pointer for keyframes that are damaged.
void pose_document(Json& root, const GltfDocument& document, const GltfData& data, int animation,
                   const AnimationTime& time, GltfNotes& notes);

}  // namespace furnace
