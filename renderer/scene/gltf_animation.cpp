#include "renderer/scene/gltf_animation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_properties.hpp"

namespace furnace {

namespace {

std::string sampler_pointer(int animation, int sampler) {
  return "/animations/" + std::to_string(animation) + "/samplers/" + std::to_string(sampler);
}

// Why times cannot be keyframes; "" when they can.
std::string times_fault(const GltfAccessor& accessor, const std::vector<float>& times) {
  if (accessor.type != ElementType::kScalar || accessor.component != ComponentType::kFloat)
    return "must be an accessor of SCALAR floats";
  if (times.empty()) return "has no keyframes";
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) return "has a time that is not finite";
    if (i > 0 && !(times[i] > times[i - 1]))
      return "keyframe " + std::to_string(i) + " is not later than the one before";
  }
  return {};
}

// In seconds. `damaged(sampler's pointer, fault)` hears of samplers without sound times.
template <class Damaged>
double length_of(const GltfDocument& document, int index, KeyframeReader& keyframes, Damaged damaged) {
  double length_s = 0;
  const GltfAnimation& animation = document.animations[std::size_t(index)];
  for (std::size_t s = 0; s < animation.samplers.size(); ++s) {
    const int input = animation.samplers[s].input;
    const std::string pointer = sampler_pointer(index, int(s)) + "/input";
    const std::vector<float> times = keyframes.read(input, pointer);
    if (const std::string fault = times_fault(keyframes.accessor(input), times); !fault.empty()) {
      damaged(pointer, fault);
    } else {
      length_s = std::max(length_s, double(times.back()));
    }
  }
  return length_s;
}

// Keyframes of one sampler.
struct Track {
  std::vector<float> times;   // s, increasing, never empty
  std::vector<float> values;  // of each keyframe `width`; of a spline in-tangent, value and out-tangent
  std::size_t width = 1;
  GltfInterpolation interpolation = GltfInterpolation::kLinear;

  // 0: in-tangent, 1: value, 2: out-tangent.
  double at(std::size_t key, std::size_t component, std::size_t part = 1) const {
    const bool spline = interpolation == GltfInterpolation::kCubicSpline;
    return values[((spline ? key * 3 + part : key) * width) + component];
  }
};

// glTF 2.0, appendix C.
std::vector<double> sample(const Track& track, double time_s, PropertyKind kind) {
  const auto later = std::upper_bound(track.times.begin(), track.times.end(), time_s);
  const auto next = std::size_t(later - track.times.begin());
  std::vector<double> result(track.width);
  const auto take_key = [&](std::size_t key) {
    for (std::size_t c = 0; c < track.width; ++c) result[c] = track.at(key, c);
  };
  const bool steps = track.interpolation == GltfInterpolation::kStep || kind == PropertyKind::kFlag;
  if (next == 0 || next == track.times.size() || steps) {
    take_key(next == 0 ? 0 : next - 1);
    return result;
  }
  const std::size_t key = next - 1;
  const double span_s = double(track.times[next]) - double(track.times[key]);
  const double t = (time_s - double(track.times[key])) / span_s;
  if (track.interpolation == GltfInterpolation::kCubicSpline) {
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t c = 0; c < track.width; ++c) {
      result[c] = (2 * t3 - 3 * t2 + 1) * track.at(key, c) +
                  span_s * (t3 - 2 * t2 + t) * track.at(key, c, 2) + (-2 * t3 + 3 * t2) * track.at(next, c) +
                  span_s * (t3 - t2) * track.at(next, c, 0);
    }
  } else if (kind == PropertyKind::kRotation) {
    const auto rotation = [&](std::size_t k) {
      return glm::dquat(track.at(k, 3), track.at(k, 0), track.at(k, 1), track.at(k, 2));
    };
    const glm::dquat turned = glm::slerp(rotation(key), rotation(next), t);  // the shorter way round
    result = {turned.x, turned.y, turned.z, turned.w};
  } else {
    for (std::size_t c = 0; c < track.width; ++c)
      result[c] = track.at(key, c) + t * (track.at(next, c) - track.at(key, c));
  }
  return result;
}

// Plays one animation of a document into its JSON.
// Threads: one. Owns: nothing.
class Player {
 public:
  Player(Json& root, const GltfDocument& document, KeyframeReader& keyframes, int animation, GltfNotes& notes)
      : root_(root), document_(document), keyframes_(keyframes), index_(animation), notes_(notes) {}

  void play(const AnimationTime& time) {
    const GltfAnimation& animation = document_.animations[std::size_t(index_)];
    const double seconds = time.loop ? wrapped(time.seconds) : time.seconds;
    for (const GltfAnimationChannel& channel : animation.channels) {
      const auto property = find_animated_property(channel.target);
      if (!property) {
        ignore(channel, "does not name a property that can be animated");
      } else if (const std::string fault = target_fault(channel.target); !fault.empty()) {
        ignore(channel, fault);
      } else {
        const Track track = read_track(channel, *property);
        write(channel.target, *property, sample(track, seconds, property->kind));
      }
    }
  }

 private:
  void ignore(const GltfAnimationChannel& channel, const std::string& why) {
    notes_.add("animation-channel-ignored", channel.pointer, why + "; it was left out");
  }

  double wrapped(double seconds) {
    const double length_s =
        length_of(document_, index_, keyframes_, [](const std::string&, const std::string&) {});
    return length_s > 0 ? seconds - std::floor(seconds / length_s) * length_s : 0;
  }

  // Makes what has a default and may be left out, so that it can be written to.
  void provide_parent(const std::string& target) {
    const std::string material = target.substr(0, target.find("/pbrMetallicRoughness/"));
    if (material != target && root_.contains(Json::json_pointer(material)))
      root_[Json::json_pointer(material)].emplace("pbrMetallicRoughness", Json::object());
    const std::size_t weights = target.find("/weights/");
    if (weights == std::string::npos || !target.starts_with("/nodes/")) return;
    const Json::json_pointer node(target.substr(0, weights));
    if (!root_.contains(node) || root_[node].contains("weights") || !root_[node].contains("mesh")) return;
    const Json& mesh = root_["meshes"][root_[node]["mesh"].get<std::size_t>()];
    if (mesh.contains("weights")) root_[node]["weights"] = mesh["weights"];
  }

  // Why nothing can be written there; "" when it can.
  std::string target_fault(const std::string& target) {
    provide_parent(target);
    const Json::json_pointer pointer(target), parent = pointer.parent_pointer();
    if (!root_.contains(parent)) return "names " + parent.to_string() + ", which the document does not have";
    if (root_[parent].is_array() && !root_.contains(pointer)) return "names a weight that does not exist";
    if (target.ends_with("/weights") && morph_targets_of(target) == 0)
      return "moves the weights of what has no morph targets";
    const bool places = target.starts_with("/nodes/") && root_[parent].contains("matrix");
    return places && !target.ends_with("weights") ? "moves a node that is placed by a matrix" : "";
  }

  // Of the mesh whose weights, or whose node's weights, the target is.
  std::size_t morph_targets_of(const std::string& target) const {
    const Json::json_pointer owner = Json::json_pointer(target).parent_pointer();
    if (!target.ends_with("/weights") || !root_.contains(owner)) return 0;
    const auto index = std::size_t(std::stoul(owner.back()));
    const std::optional<int> mesh =
        target.starts_with("/nodes/") ? document_.nodes[index].mesh : std::optional(int(index));
    if (!mesh) return 0;
    const auto& primitives = document_.meshes[std::size_t(*mesh)].primitives;
    return primitives.empty() ? 0 : primitives.front().targets.size();
  }

  Track read_track(const GltfAnimationChannel& channel, const AnimatedProperty& property) {
    const GltfAnimationSampler& sampler =
        document_.animations[std::size_t(index_)].samplers[std::size_t(channel.sampler)];
    const std::string pointer = sampler_pointer(index_, channel.sampler);
    Track track;
    track.interpolation = sampler.interpolation;
    track.times = keyframes_.read(sampler.input, pointer + "/input");
    if (const std::string fault = times_fault(keyframes_.accessor(sampler.input), track.times);
        !fault.empty())
      fail(ErrorCode::kUnprocessable, fault, pointer + "/input");
    track.values = keyframes_.read(sampler.output, pointer + "/output");
    check_values(track, sampler, property, morph_targets_of(channel.target), pointer + "/output");
    return track;
  }

  // `weights`: of the mesh, if these are what moves.
  void check_values(Track& track, const GltfAnimationSampler& sampler, const AnimatedProperty& property,
                    std::size_t weights, const std::string& pointer) const {
    const GltfAccessor& output = keyframes_.accessor(sampler.output);
    const int components = output.type < ElementType::kMat2 ? component_count(output.type) : 0;
    if (components != property.components)
      fail(ErrorCode::kUnprocessable,
           "must be an accessor of " + std::to_string(property.components) + " components each", pointer);
    const std::size_t parts = track.interpolation == GltfInterpolation::kCubicSpline ? 3 : 1;
    const std::size_t values = track.times.size() * parts;
    track.width = property.kind == PropertyKind::kWeights ? weights : std::size_t(property.components);
    if (track.width == 0 || track.values.size() != values * track.width) {
      fail(ErrorCode::kUnprocessable,
           "has " + std::to_string(output.count) + " elements for " + std::to_string(track.times.size()) +
               " keyframes",
           pointer);
    }
    const auto is_finite = [](float value) { return std::isfinite(value); };
    if (!std::all_of(track.values.begin(), track.values.end(), is_finite))
      fail(ErrorCode::kUnprocessable, "has a value that is not finite", pointer);
  }

  void write(const std::string& target, const AnimatedProperty& property, std::vector<double> values) {
    if (property.kind == PropertyKind::kRotation) {
      const glm::dquat rotation(values[3], values[0], values[1], values[2]);
      if (!(glm::length(rotation) > 1e-6)) values = {0, 0, 0, 1};  // a spline through nothing
      const double length = glm::length(glm::dquat(values[3], values[0], values[1], values[2]));
      for (double& value : values) value /= length;
    }
    for (double& value : values) value = std::clamp(value, property.least, property.most);
    Json& place = root_[Json::json_pointer(target)];
    if (property.kind == PropertyKind::kFlag) {
      place = values[0] != 0;
    } else if (property.kind == PropertyKind::kNumbers && property.components == 1) {
      place = values[0];
    } else {
      place = std::move(values);
    }
  }

  Json& root_;
  const GltfDocument& document_;
  KeyframeReader& keyframes_;
  const int index_;
  GltfNotes& notes_;
};

}  // namespace

std::vector<float> KeyframeReader::read(int accessor, const std::string& pointer) {
  check_deadline(deadline_, "keyframes");
  const GltfAccessor& numbers = data_.accessor(accessor);
  numbers_ += numbers.count * std::uint64_t(component_count(numbers.type));
  if (numbers_ > std::uint64_t(limits_.max_keyframe_numbers)) {
    fail(ErrorCode::kTooLarge,
         "the animations have more than " + std::to_string(limits_.max_keyframe_numbers) +
             " numbers in keyframes",
         pointer);
  }
  return data_.read_numbers(accessor);
}

std::vector<SceneAnimation> list_animations(const GltfDocument& document, KeyframeReader& keyframes,
                                            GltfNotes& notes) {
  std::vector<SceneAnimation> result;
  for (std::size_t i = 0; i < document.animations.size(); ++i) {
    const auto damaged = [&](const std::string& pointer, const std::string& fault) {
      notes.add("animation-damaged", pointer, fault);
    };
    result.push_back({document.animations[i].name, length_of(document, int(i), keyframes, damaged)});
  }
  return result;
}

std::optional<int> find_animation(const GltfDocument& document, const std::variant<int, std::string>& which) {
  const auto count = int(document.animations.size());
  if (const int* index = std::get_if<int>(&which))
    return *index >= 0 && *index < count ? std::optional(*index) : std::nullopt;
  for (int i = 0; i < count; ++i)
    if (document.animations[std::size_t(i)].name == std::get<std::string>(which)) return i;
  return std::nullopt;
}

void pose_document(Json& root, const GltfDocument& document, KeyframeReader& keyframes, int animation,
                   const AnimationTime& time, GltfNotes& notes) {
  Player(root, document, keyframes, animation, notes).play(time);
}

}  // namespace furnace
