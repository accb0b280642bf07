// OBJ, STL and PLY -> Scene, the counterpart of gltf_import.hpp. Files are taken as they are, a unit is a metre; what
// their numbers mean to this renderer is said here and in model_material.hpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/decoder.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Imports the model of a bundle that is no glTF. `up`: which of the file's axes points up; none: Z of an STL, told by a
// Note, else Y. Colours of vertices and facets are sRGB as displayed.
// Errors: those of Decoder::model, at "/scene/model". A missing file of materials or texture becomes a Note.
Scene import_model(const ModelBundle& bundle, std::optional<UpAxis> up, const ImportLimits& limits,
                   Decoder& decoder, const Deadline& deadline);

// The names of the files that a model's document names: those of a glTF as gltf_external_uris, with its errors, the MTL
// files of an OBJ, the textures of a PLY.
std::vector<std::string> model_siblings(const Blob& document, ModelFormat format, const ImportLimits& limits);

}  // namespace furnace
