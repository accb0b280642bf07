// What takes the picture: the camera and the output, after the schema was satisfied.
#pragma once

#include "api/render_request.hpp"
#include "api/request_values.hpp"

namespace furnace::api {

void read_camera(const Value& value, CameraSpec& spec, Faults& faults);
void read_output(const Value& value, const RequestLimits& limits, OutputSpec& spec, Faults& faults);

// `camera` with the sequence that its pictures belong to, if any.
void read_motion(const Value& camera, const std::optional<Sequence>& sequence, CameraMotion& spec,
                 Faults& faults);

}  // namespace furnace::api
