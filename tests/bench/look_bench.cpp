// What each layer of a material, each light and each quality costs: warm CPU time of a sphere at 512 px relative to the plain one's, in
// one run. Prints a table; --benchmark_out=FILE writes the figures as JSON.
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/renderer.hpp"
#include "api/render_request.hpp"
#include "tests/bench/bench_main.hpp"

namespace furnace {
namespace {

// Members of the request's parts, over those of the plain sphere.
struct Look {
  const char* kind;
  const char* name;
  const char* material = "";
  const char* scene = "";
  const char* output = "";
  const char* environment = "";
};

constexpr Look kLooks[] = {
    {"plain", "pbr"},
    {"model", "schlick-beckmann", R"(,"model":"schlick-beckmann")"},
    {"model", "blinn-phong", R"(,"model":"blinn-phong")"},
    {"model", "phong", R"(,"model":"phong")"},
    {"model", "unlit", R"(,"unlit":true)"},
    {"layer", "specular", R"(,"specular":0.5)"},
    {"layer", "clearcoat", R"(,"clearcoat":1)"},
    {"layer", "sheen", R"(,"sheenColor":[1,1,1],"sheenRoughness":0.5)"},
    {"layer", "anisotropy", R"(,"anisotropy":0.7)"},
    {"layer", "iridescence", R"(,"iridescence":1)"},
    {"layer", "diffuse transmission", R"(,"diffuseTransmission":0.5)"},
    {"layer", "transmission", R"(,"transmission":1)"},
    {"layer", "volume", R"(,"transmission":1,"thicknessMetres":0.5)"},
    {"layer", "dispersion", R"(,"transmission":1,"thicknessMetres":0.5,"dispersion":1)"},
    {"light", "directional", "", R"(,"lights":[{"type":"directional","illuminanceLux":3}])"},
    {"light", "point", "", R"(,"lights":[{"type":"point","position":[2,2,2],"intensityCandela":9}])"},
    {"light", "spot", "",
     R"(,"lights":[{"type":"spot","position":[2,2,2],"direction":[-1,-1,-1],"intensityCandela":9}])"},
    {"light", "rectangle", "",
     R"(,"lights":[{"type":"rectangle","position":[2,2,2],"direction":[-1,-1,-1],"luminanceNits":9}])"},
    {"light", "disc", "",
     R"(,"lights":[{"type":"disc","position":[2,2,2],"direction":[-1,-1,-1],"luminanceNits":9}])"},
    {"light", "sphere", "", R"(,"lights":[{"type":"sphere","position":[2,2,2],"luminanceNits":9}])"},
    {"quality", "draft", "", "", R"(,"quality":"draft")"},
    {"quality", "high", "", "", R"(,"quality":"high")"},
    {"quality", "high, all seen", "", "", R"(,"quality":"high")", R"("visibility":"off")"},
    {"film", "bloom", "", "", R"(,"bloom":{})"},
};

std::string document_of(const Look& look) {
  return fmt::format(
      R"({{"scene":{{"nodes":[{{"mesh":"builtin:sphere","material":"m"}}],)"
      R"("materials":{{"m":{{"roughness":0.3{}}}}}{}}},"environment":{{{}}},"output":{{"width":512,"height":512{}}}}})",
      look.material, look.scene, look.environment, look.output);
}

double cpu_ms() {
  return double(std::clock()) * 1000 / CLOCKS_PER_SEC;
}

struct Cost {
  double cold_cpu_ms = 0, warm_cpu_ms = 0;
};

Cost measure(Renderer& renderer, const Look& look) {
  FileAssets files({}, 0, 1);
  const RenderSpec spec = api::parse_render_request(document_of(look), AssetResolver(files, {}, {}), {});
  Cost cost;
  const double start = cpu_ms();
  renderer.render(spec, Deadline());
  cost.cold_cpu_ms = cpu_ms() - start;
  const int times = std::clamp(64 / spec.output.samples, 3, 12);
  // The least of some: what else a machine does only adds.
  cost.warm_cpu_ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < times; ++i) {
    const double warm_start = cpu_ms();
    renderer.render(spec, Deadline());
    cost.warm_cpu_ms = std::min(cost.warm_cpu_ms, cpu_ms() - warm_start);
  }
  return cost;
}

nlohmann::json run(const std::string&) {
  WorkerPool pool(int(std::max(1l, sysconf(_SC_NPROCESSORS_ONLN))));
  Renderer renderer({}, pool, decode::in_process_decoder());
  measure(renderer, kLooks[0]);  // what every picture needs once
  nlohmann::json rows = nlohmann::json::array();
  double plain_ms = 0;
  fmt::print("{:<10}{:<22}{:>14}{:>14}{:>10}\n", "", "", "first cpu ms", "warm cpu ms", "to plain");
  for (const Look& look : kLooks) {
    const Cost cost = measure(renderer, look);
    if (plain_ms == 0) plain_ms = cost.warm_cpu_ms;
    const double ratio = cost.warm_cpu_ms / plain_ms;
    fmt::print("{:<10}{:<22}{:>14.0f}{:>14.1f}{:>10.2f}\n", look.kind, look.name, cost.cold_cpu_ms,
               cost.warm_cpu_ms, ratio);
    rows.push_back({{"kind", look.kind},
                    {"name", look.name},
                    {"coldCpuMs", cost.cold_cpu_ms},
                    {"warmCpuMs", cost.warm_cpu_ms},
                    {"toPlain", ratio}});
  }
  return {{"rows", rows}};
}

}  // namespace
}  // namespace furnace

int main(int argc, char** argv) {
  return furnace::bench_main(argc, argv, furnace::run);
}
