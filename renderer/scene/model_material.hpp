// Materials of MTL files as those of this renderer. MTL describes a Phong surface; what has no counterpart is left out.
#pragma once

#include <map>
#include <span>
#include <string>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/decoder.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/mtl_text.hpp"
#include "renderer/scene/plain_model.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Kd and Ke are sRGB as displayed, Ke linear above 1; a map_Kd stands in place of Kd. d below 1 blends, as does a map_d
// that is the map_Kd. Ns is the exponent n of Blinn and Phong, with roughness alpha^2 = 2 / (n + 2) (Walter et al. 2007,
// "Microfacet Models for Refraction through Rough Surfaces"); Pr, Pm, Pc and Pcr are taken as they are. norm is a normal
// map, map_Bump is one if it looks like one. -o, -s and -clamp place a texture. Everything else is without effect.
// Threads: one. Owns: nothing; all it names outlives it.
class MaterialMaker {
 public:
  // `mtl` is what the model's materials were read from; empty where they are not of an MTL file.
  MaterialMaker(const PlainModel& model, const MtlText& mtl, const ModelBundle& bundle, Decoder& decoder,
                const Deadline& deadline, Scene& scene, GltfNotes& notes)
      : model_(model),
        mtl_(mtl),
        bundle_(bundle),
        decoder_(decoder),
        deadline_(deadline),
        scene_(scene),
        notes_(notes) {}

  // Index into the scene's materials. Vertex colours stand in place of the grey that is assumed where no Kd is stated.
  int material(std::uint32_t plain, bool colored);

 private:
  Material made_of(const PlainMaterial& from, bool colored);
  void add_texture(const PlainMaterial& from, PlainTexture what, TextureUse use, Material& to);
  std::optional<int> image_of(const PlainMaterial& from, PlainTexture what);
  void tell_unused(const PlainMaterial& from, PlainTexture what, const char* why);
  void tell_others(const PlainMaterial& from);
  std::span<const MtlTexture> statements_of(const PlainMaterial& from) const;
  // The last one of that use; null: there is none.
  const MtlTexture* statement_of(const PlainMaterial& from, PlainTexture what) const;

  const PlainModel& model_;
  const MtlText& mtl_;
  const ModelBundle& bundle_;
  Decoder& decoder_;
  const Deadline& deadline_;
  Scene& scene_;
  GltfNotes& notes_;
  std::map<std::pair<std::uint32_t, bool>, int> made_;
  std::map<std::string, int> images_;  // by sibling_name
  std::map<int, bool> normal_maps_;    // whether an image looks like one
};

// Whether nearly all texels, as directions, have length 1 and point outwards.
bool looks_like_normal_map(const Image& image);

}  // namespace furnace
