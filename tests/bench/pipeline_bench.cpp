// Where the time of a picture goes: stages cold and warm, latency, throughput and CPU seconds, at 512 and 1024 px.
// Ratios are taken within one run, so that another machine's speed cancels. Prints tables; --benchmark_out=FILE writes the figures as JSON.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "server/render_service.hpp"
#include "tests/bench/bench_main.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr int kWarmRenders = 20;  // a batch, as a user's
constexpr int kFewWarmRenders = 3;
const fs::path kData = fs::path(FURNACE_SOURCE_DIR).parent_path() / "shared" / "data";

struct Subject {
  std::string name;
  std::string model;        // below kData, or empty: the built-in shader ball
  std::string environment;  // below kData, or empty: the built-in studio
  int samples = 1;
  EnvironmentVisibility visibility = EnvironmentVisibility::kOff;
  bool plays = false;    // the model's first animation, half a second after its beginning
  double shutter_s = 0;  // of that animation
  bool turns = false;    // every picture from elsewhere: nothing found visible serves the next one
};

double wall_ms() {
  return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
}
double cpu_ms() {
  return double(std::clock()) * 1000 / CLOCKS_PER_SEC;
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

RenderSpec spec_of(const Subject& subject, FileAssets& files, int side) {
  RenderSpec spec;
  spec.output.width = spec.output.height = side;
  spec.output.samples = subject.samples;
  spec.environment.visibility = subject.visibility;
  if (subject.model.empty()) {
    NodeSpec ball;
    ball.mesh = "shader-ball";
    ball.material = "gold";
    spec.scene.nodes = {ball};
  } else {
    spec.scene.model = files.read_model(subject.model, "", {});
  }
  if (subject.plays) spec.scene.animations = {{0, {0.5, false}}};
  spec.camera.motion.shutter_s = subject.shutter_s;
  if (!subject.environment.empty())
    spec.environment.map = EnvironmentFile{files.read(subject.environment, "")};
  return spec;
}

struct Row {
  std::string subject;
  int side = 0;
  StageTimes cold, warm;  // warm: means
  double cold_ms = 0, cold_cpu_ms = 0;
  double warm_p50_ms = 0, warm_mean_ms = 0, warm_cpu_ms = 0, per_second = 0;
  std::size_t bytes = 0;

  double encode_to_draw() const { return warm.encode_ms / warm.draw_ms; }
  double warm_share() const { return (warm.draw_ms + warm.readback_ms + warm.encode_ms) / warm_mean_ms; }
};

void add(StageTimes& sum, const StageTimes& times, double weight) {
  for (double StageTimes::*stage :
       {&StageTimes::queue_ms, &StageTimes::decode_ms, &StageTimes::bake_ms, &StageTimes::upload_ms,
        &StageTimes::draw_ms, &StageTimes::readback_ms, &StageTimes::encode_ms}) {
    sum.*stage += times.*stage * weight;
  }
}

Row measure(const Subject& subject, int side) {
  Row row{subject.name, side, {}, {}};
  FileAssets files({kData}, 1ll << 30, 1ll << 30);
  WorkerPool pool(int(std::max(1l, sysconf(_SC_NPROCESSORS_ONLN))));
  Admission admission(1, 0);

  const double start = wall_ms(), start_cpu = cpu_ms();
  Renderer renderer({}, pool, decode::in_process_decoder());
  RenderCache none({0, {}, 0});
  RenderService service(painter_of(renderer), admission, pool, none);
  RenderSpec spec = spec_of(subject, files, side);
  const Rendered first = service.render(spec, Deadline());
  row.cold_ms = wall_ms() - start;
  row.cold_cpu_ms = cpu_ms() - start_cpu;
  row.cold = first.times;
  row.bytes = first.image->bytes.size();

  const int renders = subject.samples == 1 ? kWarmRenders : kFewWarmRenders;
  std::vector<double> latencies;
  const double warm_start = wall_ms(), warm_start_cpu = cpu_ms();
  for (int i = 0; i < renders; ++i) {
    if (subject.turns) spec.camera.view = OrbitCamera{0.61 + 0.01 * (i + 1)};
    const double begin = wall_ms();
    const Rendered image = service.render(spec, Deadline());
    latencies.push_back(wall_ms() - begin);
    add(row.warm, image.times, 1.0 / renders);
    if (!subject.turns && image.image->bytes != first.image->bytes)
      fail(ErrorCode::kInternal, "a warm picture differs from the cold one");
  }
  const double elapsed = wall_ms() - warm_start;
  row.warm_mean_ms = elapsed / renders;
  row.warm_cpu_ms = (cpu_ms() - warm_start_cpu) / renders;
  row.per_second = renders * 1000 / elapsed;
  std::nth_element(latencies.begin(), latencies.begin() + renders / 2, latencies.end());
  row.warm_p50_ms = latencies[std::size_t(renders) / 2];
  return row;
}

// From exec to the file: what a command-line user waits for. The best of three: the disk's cache is warm then.
double first_picture_ms(const std::string& program, const std::string& arguments) {
  const std::string command =
      program + " render " + arguments + " -o /dev/null --format png > /dev/null 2>&1";
  double best = 1e12;
  for (int i = 0; i < 3; ++i) {
    const double start = wall_ms();
    if (std::system(command.c_str()) != 0) return -1;
    best = std::min(best, wall_ms() - start);
  }
  return best;
}

void print(const std::vector<Row>& rows) {
  fmt::print("{:<24}{:>6}{:>6} {:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "subject", "px", "", "decode", "bake",
             "upload", "draw", "readback", "encode");
  for (const Row& row : rows) {
    for (const auto& [label, t] : {std::pair{"cold", row.cold}, std::pair{"warm", row.warm}}) {
      fmt::print("{:<24}{:>6}{:>6} {:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.2f}{:>9.1f}\n", row.subject, row.side,
                 label, t.decode_ms, t.bake_ms, t.upload_ms, t.draw_ms, t.readback_ms, t.encode_ms);
    }
  }
  fmt::print("\n{:<24}{:>6} {:>9}{:>10}{:>10}{:>10}{:>9}{:>13}{:>12}\n", "subject", "px", "cold ms",
             "warm p50", "warm cpu", "images/s", "kB", "encode/draw", "warm share");
  for (const Row& row : rows) {
    fmt::print("{:<24}{:>6} {:>9.0f}{:>10.1f}{:>10.1f}{:>10.1f}{:>9}{:>13.2f}{:>12.3f}\n", row.subject,
               row.side, row.cold_ms, row.warm_p50_ms, row.warm_cpu_ms, row.per_second, row.bytes / 1000,
               row.encode_to_draw(), row.warm_share());
  }
}

nlohmann::json json_of(const StageTimes& t) {
  return {{"decodeMs", t.decode_ms}, {"bakeMs", t.bake_ms},         {"uploadMs", t.upload_ms},
          {"drawMs", t.draw_ms},     {"readbackMs", t.readback_ms}, {"encodeMs", t.encode_ms}};
}

nlohmann::json json_of(const std::vector<Row>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : rows) {
    list.push_back({{"subject", row.subject},
                    {"sidePx", row.side},
                    {"cold", json_of(row.cold)},
                    {"warm", json_of(row.warm)},
                    {"coldMs", row.cold_ms},
                    {"coldCpuMs", row.cold_cpu_ms},
                    {"warmP50Ms", row.warm_p50_ms},
                    {"warmCpuMs", row.warm_cpu_ms},
                    {"imagesPerSecond", row.per_second},
                    {"encodeToDraw", row.encode_to_draw()},
                    {"warmShareOfDrawReadbackEncode", row.warm_share()}});
  }
  return list;
}

nlohmann::json run(const std::string& self) {
  std::vector<Subject> subjects = {{"shader-ball", "", ""}};
  if (fs::exists(kData / "models")) {
    subjects.push_back(
        {"WaterBottle", "models/WaterBottle/WaterBottle.gltf", "environments/venice_sunset_1k.hdr"});
    subjects.push_back(
        {"FlightHelmet", "models/FlightHelmet/FlightHelmet.gltf", "environments/studio_small_03_1k.hdr"});
  } else {
    fmt::print("no shared data beside the project: only built-ins are measured\n");
  }
  std::vector<Row> rows;
  for (const Subject& subject : subjects) {
    for (const int side : {512, 1024}) rows.push_back(measure(subject, side));
  }
  for (Subject subject : subjects) {
    subject.name += " turning";
    subject.turns = true;
    for (const int side : {512, 1024}) rows.push_back(measure(subject, side));
  }
  for (Subject subject : subjects) {
    subject.samples = kVisibilitySamples;
    subject.name += " high";
    rows.push_back(measure(subject, 512));
    subject.visibility = EnvironmentVisibility::kOn;
    subject.name += " +";
    rows.push_back(measure(subject, 512));
  }
  if (fs::exists(kData / "models")) {
    Subject walker{"Fox high", "models/Fox.glb", ""};
    walker.samples = kVisibilitySamples;
    walker.plays = true;
    rows.push_back(measure(walker, 512));
    walker.name += " in motion";
    walker.shutter_s = 0.02;
    rows.push_back(measure(walker, 512));
  }
  print(rows);

  nlohmann::json report = {{"rows", json_of(rows)}, {"peakRssMb", peak_rss_mb()}};
  fmt::print("\npeak resident memory of all of the above: {:.0f} MB\n", peak_rss_mb());
  const fs::path program = fs::path(self).parent_path() / ".." / "furnace";
  if (fs::exists(program)) {
    const std::string request =
        (fs::temp_directory_path() / fmt::format("furnace_bench_{}.json", getpid())).string();
    std::ofstream(request) << "{}";
    report["firstPictureMs"] = first_picture_ms(program.string(), request + " --width 512 --height 512");
    fs::remove(request);
    fmt::print("process start to the first 512 px PNG of a built-in scene: {:.0f} ms\n",
               report["firstPictureMs"].get<double>());
  }
  return report;
}

}  // namespace
}  // namespace furnace

int main(int argc, char** argv) {
  return furnace::bench_main(argc, argv, furnace::run);
}
