#include "api/model_report.hpp"

#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace furnace::api {
namespace {

double mebibytes(std::int64_t bytes) {
  return double(bytes) / (1 << 20);
}

std::string_view or_unnamed(const std::string& name) {
  return name.empty() ? "(unnamed)" : std::string_view(name);
}

void add_rest(std::int64_t more, std::string& out) {
  if (more > 0) out += fmt::format("  and {} more\n", more);
}

void add_drawn(const ModelReport& report, std::string& out) {
  const ModelReport::Drawn& drawn = report.drawn;
  out += fmt::format("draws {} triangles, {} lines, {} points in {} instances of {} meshes, {} nodes\n",
                     drawn.triangles, drawn.lines, drawn.points, drawn.instances, drawn.meshes, drawn.nodes);
  if (drawn.bounds.empty()) return;
  const glm::vec3 size = drawn.bounds.max - drawn.bounds.min;
  out += fmt::format("  {:.4g} x {:.4g} x {:.4g} m, from ({:.4g}, {:.4g}, {:.4g})\n", size.x, size.y, size.z,
                     drawn.bounds.min.x, drawn.bounds.min.y, drawn.bounds.min.z);
}

void add_materials(const ModelReport& report, std::string& out) {
  out += fmt::format("{} materials\n", report.materials.size());
  for (const ModelReport::MaterialInfo& material : report.materials.items) {
    out += fmt::format("  {}: {} textures{}{}\n", or_unnamed(material.name), material.textures.size(),
                       material.extensions.items.empty() ? "" : ", ",
                       fmt::join(material.extensions.items, ", "));
  }
  add_rest(report.materials.more, out);
}

void add_images(const ModelReport& report, std::string& out) {
  const ModelReport::Bytes& bytes = report.bytes;
  out += fmt::format("{} images: {:.1f} MiB in files, {:.1f} MiB on the GPU\n", report.images.size(),
                     mebibytes(bytes.images_encoded), mebibytes(bytes.images_gpu));
  for (const ModelReport::ImageInfo& image : report.images.items) {
    const std::string_view name = or_unnamed(image.uri.empty() ? image.name : image.uri);
    if (image.missing) {
      out += fmt::format("  {}: missing\n", name);
    } else {
      out += fmt::format("  {}: {} {} x {} px, {} bytes\n", name,
                         image.format.empty() ? "unknown" : image.format, image.width, image.height,
                         image.encoded_bytes);
    }
  }
  add_rest(report.images.more, out);
}

void add_names(std::string_view what, const ReportList<std::string>& names, std::string& out) {
  if (names.size() == 0) return;
  out += fmt::format("{}: {}\n", what, fmt::join(names.items, ", "));
  add_rest(names.more, out);
}

}  // namespace

std::string model_report_text(const ModelReport& report) {
  std::string out = fmt::format("glTF {} ({}){}{}, {} bytes\n", report.asset.version, report.asset.container,
                                report.asset.generator.empty() ? "" : ", by ", report.asset.generator,
                                report.bytes.document);
  add_drawn(report, out);
  add_materials(report, out);
  add_images(report, out);
  if (report.animations.size() > 0) out += fmt::format("{} animations\n", report.animations.size());
  for (const ModelReport::AnimationInfo& animation : report.animations.items)
    out += fmt::format("  {}: {:.4g} s, {} channels\n", or_unnamed(animation.name), animation.duration_s,
                       animation.channels.size());
  add_rest(report.animations.more, out);
  if (report.skins.size() + report.cameras.size() + report.lights.size() > 0)
    out += fmt::format("{} skins, {} cameras, {} lights\n", report.skins.size(), report.cameras.size(),
                       report.lights.size());
  add_names("variants", report.variants, out);
  add_names("extensions", report.extensions.used, out);
  add_names("not supported", report.extensions.unsupported, out);
  for (const Note& note : report.notes)
    out += fmt::format("note: {}: {} (at {})\n", note.code, note.message, note.pointer);
  return out;
}

}  // namespace furnace::api
