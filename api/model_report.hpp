// What is in a model, as JSON: the answer of /v1/inspect, and what `furnace inspect` prints.
#pragma once

#include <string>

#include "renderer/scene/model_report.hpp"

namespace furnace::api {

// Members that have nothing to say are left out. A list that was cut has its row in "more": JSON pointer into this
// document -> how many items are left out.
std::string model_report_json(const ModelReport& report);

// The same in short, for people.
std::string model_report_text(const ModelReport& report);

}  // namespace furnace::api
