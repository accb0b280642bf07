#include "api/inspect_request.hpp"

#include "api/contract.hpp"
#include "api/model_reference.hpp"
#include "api/request_values.hpp"
#include "api/validate.hpp"

namespace furnace::api {

InspectRequest parse_inspect_request(std::string_view json, const AssetResolver& assets,
                                     const RequestLimits& limits) {
  static const Schema schema(inspect_request_schema());
  const Document document = Document::parse(json, {limits.max_json_depth, limits.max_json_bytes});
  fail_if_any(schema.problems(document));
  const Value root = document.root();
  InspectRequest request;
  read(root["gltfScene"], request.options.scene);
  read(root["variant"], request.options.variant);
  Faults faults;
  request.model = read_model_reference(root["model"], root["files"], assets, faults);
  faults.throw_if_any();
  return request;
}

}  // namespace furnace::api
