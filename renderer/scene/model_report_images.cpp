// Materials, textures and images: what is declared, and what the headers of the files say.
#include <array>
#include <set>

#include "renderer/base/error.hpp"
#include "renderer/image/image_header.hpp"
#include "renderer/scene/model_report_parts.hpp"

namespace furnace {

namespace {

// Beyond it no decoder goes, and sums over millions of images stay far from what 64 bits hold.
constexpr std::uint32_t kMaxSidePx = 1 << 16;

// The one that is taken if it can be read.
std::optional<int> image_of(const GltfDocument& document, int texture) {
  const std::vector<int>& images = document.textures[static_cast<std::size_t>(texture)].images;
  return images.empty() ? std::nullopt : std::optional(images.front());
}

std::vector<ImageWanted> wanted_images(const GltfDocument& document) {
  std::vector<ImageWanted> wanted(document.images.size());
  for (const GltfMaterial& material : document.materials) {
    for (std::size_t use = 0; use < kTextureUses; ++use) {
      if (!material.textures[use]) continue;
      const std::optional<int> image = image_of(document, material.textures[use]->texture);
      if (!image) continue;
      ImageWanted& entry = wanted[static_cast<std::size_t>(*image)];
      (is_color_texture(material.values, TextureUse(use)) ? entry.as_color : entry.as_numbers) = true;
    }
  }
  return wanted;
}

// Four channels, every level down to a single texel; sRGB has eight bits (renderer/prepare.cpp).
std::int64_t gpu_bytes(std::int64_t width, std::int64_t height, int bits, const ImageWanted& wanted) {
  std::int64_t texels = 0;
  for (;; width = std::max<std::int64_t>(1, width / 2), height = std::max<std::int64_t>(1, height / 2)) {
    texels += width * height;
    if (width == 1 && height == 1) break;
  }
  return texels * 4 * ((wanted.as_color ? 1 : 0) + (wanted.as_numbers ? bits / 8 : 0));
}

class ImageReporter {
 public:
  ImageReporter(const ReportSource& source, ReportBudget& budget, GltfNotes& notes)
      : source_(source), budget_(budget), notes_(notes), wanted_(wanted_images(source.document)) {}

  ModelReport::ImageInfo report(std::size_t index) {
    check_deadline(source_.deadline, "inspect");
    const GltfImage& image = source_.document.images[index];
    ModelReport::ImageInfo info;
    info.name = budget_.text(source_.about.image_names[index]);
    info.media_type = budget_.text(source_.about.image_media_types[index]);
    info.buffer_view = image.buffer_view;
    if (!image.buffer_view) info.uri = is_data_uri(image.uri) ? "data:" : budget_.text(image.uri);
    if (const std::optional<Blob> encoded = bytes_of(image, index)) {
      describe_image(*encoded, wanted_[index], "/images/" + std::to_string(index), notes_, info);
    } else {
      info.missing = true;
    }
    return info;
  }

  const std::vector<std::string>& missing_files() const { return missing_; }

 private:
  // None also for an image that nothing draws and whose bytes are not there or broken.
  std::optional<Blob> bytes_of(const GltfImage& image, std::size_t index) {
    const std::string pointer = "/images/" + std::to_string(index);
    try {
      if (image.buffer_view) return source_.data.view_blob(*image.buffer_view);
      if (is_data_uri(image.uri)) return Blob(decode_data_uri(image.uri, pointer + "/uri"));
      const std::string path = decode_relative_uri(image.uri, pointer + "/uri");
      const auto sibling = source_.bundle.siblings.find(path);
      if (sibling != source_.bundle.siblings.end()) return sibling->second;
      if (known_missing_.insert(path).second) missing_.push_back(path);
      notes_.add("image-missing", pointer + "/uri", "the file " + budget_.text(image.uri) + " is missing");
    } catch (const Error& error) {
      notes_.add("image-unreadable", error.pointer, error.message);
    }
    return std::nullopt;
  }

  const ReportSource& source_;
  ReportBudget& budget_;
  GltfNotes& notes_;
  const std::vector<ImageWanted> wanted_;
  std::set<std::string> known_missing_;
  std::vector<std::string> missing_;
};

}  // namespace

void describe_image(const Blob& encoded, const ImageWanted& wanted, const std::string& pointer,
                    GltfNotes& notes, ModelReport::ImageInfo& info) {
  info.encoded_bytes = std::int64_t(encoded.size());
  const std::optional<ImageHeader> header = read_image_header(encoded.bytes());
  if (!header) return;
  info.format = header->format;
  if (!header->is_complete()) {
    if (header->format != "AVIF") {
      notes.add("image-damaged", pointer,
                "is a " + std::string(header->format) + " whose header cannot be read");
    }
    return;
  }
  info.width = header->width;
  info.height = header->height;
  info.channels = header->channels;
  info.bits = header->bits;
  if (info.channels == 0 || std::max(info.width, info.height) > kMaxSidePx) return;
  info.decoded_bytes = std::int64_t{info.width} * info.height * info.channels * (info.bits / 8);
  info.gpu_bytes = gpu_bytes(info.width, info.height, info.bits, wanted);
}

void count_image(const ModelReport::ImageInfo& info, ModelReport& report) {
  report.bytes.images_encoded += info.encoded_bytes;
  report.bytes.images_decoded += info.decoded_bytes;
  report.bytes.images_gpu += info.gpu_bytes;
}

void report_materials(const ReportSource& source, ReportBudget& budget, ModelReport& report) {
  const GltfDocument& document = source.document;
  report.materials = budget.list<ModelReport::MaterialInfo>(document.materials.size(), [&](std::size_t i) {
    const GltfMaterial& material = document.materials[i];
    ModelReport::MaterialInfo info;
    info.name = budget.text(material.values.name);
    info.alpha_mode = material.values.alpha_mode;
    info.double_sided = material.values.double_sided;
    info.extensions = budget.texts(source.about.material_extensions[i]);
    std::vector<ModelReport::TextureUseInfo> uses;
    for (std::size_t use = 0; use < kTextureUses; ++use) {
      const auto& ref = material.textures[use];
      if (!ref) continue;
      uses.push_back({texture_use_name(TextureUse(use)), ref->texture, image_of(document, ref->texture),
                      ref->uv_set, ref->transform != UvTransform()});
    }
    info.textures =
        budget.list<ModelReport::TextureUseInfo>(uses.size(), [&](std::size_t k) { return uses[k]; });
    return info;
  });
  report.textures = budget.list<ModelReport::TextureInfo>(document.textures.size(), [&](std::size_t i) {
    return ModelReport::TextureInfo{budget.text(source.about.texture_names[i]),
                                    image_of(document, static_cast<int>(i)), document.textures[i].sampler};
  });
}

void report_images(const ReportSource& source, ReportBudget& budget, GltfNotes& notes, ModelReport& report) {
  ImageReporter reporter(source, budget, notes);
  const std::size_t count = source.document.images.size();
  const auto counted = [&](std::size_t i) {
    ModelReport::ImageInfo info = reporter.report(i);
    count_image(info, report);
    return info;
  };
  report.images = budget.list<ModelReport::ImageInfo>(count, counted);
  // The sums are of all, listed or not.
  for (std::size_t i = report.images.items.size(); i < count; ++i) counted(i);
  report.missing_files = budget.texts(reporter.missing_files());
}

}  // namespace furnace
