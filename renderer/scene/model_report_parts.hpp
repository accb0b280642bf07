// The parts of a model's report, one function each; model_report.cpp puts them together.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "renderer/scene/gltf_about.hpp"
#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/model_report.hpp"

namespace furnace {

// Holds a report to its limits. Threads: one. Owns: what is left of them.
class ReportBudget {
 public:
  explicit ReportBudget(const ReportLimits& limits) : limits_(limits), left_(limits.max_items_total) {}

  // make(i) for as many of `count` as there is room for.
  template <class T, class Make>
  ReportList<T> list(std::size_t count, Make&& make) {
    ReportList<T> result;
    const std::int64_t room = std::min({std::int64_t(count), limits_.max_items, left_});
    left_ -= room;
    for (std::int64_t i = 0; i < room; ++i) result.items.push_back(make(static_cast<std::size_t>(i)));
    result.more = std::int64_t(count) - room;
    return result;
  }
  ReportList<std::string> texts(const std::vector<std::string>& all) {
    return list<std::string>(all.size(), [&](std::size_t i) { return text(all[i]); });
  }
  std::string text(std::string_view whole) const { return shortened(whole, limits_.max_text_bytes); }

 private:
  const ReportLimits limits_;
  std::int64_t left_;
};

struct ReportSource {
  const ModelBundle& bundle;
  const GltfDocument& document;
  const GltfData& data;
  const GltfAbout& about;
  const ImportLimits& limits;
  const Deadline& deadline;
};

// model_report.cpp
void report_drawn(const Scene& scene, ModelReport& report);

// model_report_meshes.cpp
void report_meshes(const ReportSource& source, ReportBudget& budget, ModelReport& report);
void report_animations(const ReportSource& source, const Scene& scene, ReportBudget& budget,
                       ModelReport& report);

// model_report_images.cpp
// How the materials read an image.
struct ImageWanted {
  bool as_color = false;
  bool as_numbers = false;
};
void describe_image(const Blob& encoded, const ImageWanted& wanted, const std::string& pointer,
                    GltfNotes& notes, ModelReport::ImageInfo& info);
void count_image(const ModelReport::ImageInfo& info, ModelReport& report);
void report_materials(const ReportSource& source, ReportBudget& budget, ModelReport& report);
void report_images(const ReportSource& source, ReportBudget& budget, GltfNotes& notes, ModelReport& report);

// model_report_plain.cpp
ModelReport inspect_plain(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits,
                          const Deadline& deadline, const ReportLimits& report_limits);

}  // namespace furnace
