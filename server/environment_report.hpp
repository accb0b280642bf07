// EnvironmentBake -> the contract's report.
#pragma once

#include <string>

#include "api/environment_report.hpp"
#include "renderer/environment_bake.hpp"
#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

// Of a bake for a render: its maps are named, their sizes not known.
api::EnvironmentReport report_of(const std::string& name, const Blob& encoded,
                                 const EnvironmentSummary& summary, bool was_cached);
// Of a whole bake.
api::EnvironmentReport report_of(const std::string& name, const Blob& encoded, const EnvironmentBake& bake);

}  // namespace furnace
