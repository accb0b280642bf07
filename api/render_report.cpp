#include "api/render_report.hpp"

#include <nlohmann/json.hpp>

namespace furnace::api {

std::string render_report_json(const RenderReport& report) {
  using OrderedJson = nlohmann::ordered_json;
  OrderedJson stages = OrderedJson::array();
  for (const RenderReport::Stage& stage : report.stages) {
    OrderedJson row = {{"name", stage.name}, {"ms", stage.ms}};
    if (!stage.cache.empty()) row["cache"] = stage.cache;
    stages.push_back(std::move(row));
  }
  OrderedJson notes = OrderedJson::array();
  for (const Note& note : report.notes)
    notes.push_back({{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
  const OrderedJson json = {{"request", report.request}, {"fingerprint", report.fingerprint},
                            {"etag", report.etag},       {"mediaType", report.media_type},
                            {"width", report.width},     {"height", report.height},
                            {"samples", report.samples}, {"frames", report.frames},
                            {"bytes", report.bytes},     {"exposureEv", report.exposure_ev},
                            {"stages", stages},          {"notes", notes}};
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace furnace::api
