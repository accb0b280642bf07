#include "server/inspect_routes.hpp"

#include "renderer/scene/model_errors.hpp"
#include "api/inspect_request.hpp"
#include "api/model_report.hpp"
#include "server/asset_routes.hpp"
#include "server/negotiation.hpp"
#include "server/request_body.hpp"

namespace furnace {
namespace {

constexpr std::string_view kModelPart = "model";
constexpr std::string_view kWholeModel = R"({"model":"part:model"})";

RequestBody read_inspect_body(const Request& request, int max_parts) {
  const std::string type = media_type_essence(request.header("Content-Type"));
  const bool is_model = type.starts_with("model/") || type == "application/octet-stream";
  if (!is_model) return read_body(request, max_parts);
  return {kWholeModel, {{std::string(kModelPart), Blob(std::string(request.body))}}};
}

}  // namespace

Reply inspect_model(const Doors& doors, std::string_view document, std::map<std::string, Blob> parts,
                    const Deadline& deadline) {
  const api::InspectRequest wanted = api::parse_inspect_request(
      document, references(doors, std::move(parts), deadline), doors.capabilities.request);
  const Admission::Seat seat = doors.admission.enter(deadline);
  const ModelReport report = import_for("/model", [&] {
    return inspect_model(doors.decoder, *wanted.model, wanted.options, doors.capabilities.import, deadline);
  });
  return Reply{200, "application/json", api::model_report_json(report), {}}.with("Cache-Control", "no-store");
}

Reply post_inspect(const Doors& doors, const Request& request) {
  RequestBody body = read_inspect_body(request, doors.max_parts);
  return inspect_model(doors, body.document, std::move(body.parts), request.deadline);
}

}  // namespace furnace
