#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/assets/zip_reader.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "renderer/gl/context.hpp"
#include "renderer/scene/model_format.hpp"
#include "api/render_request.hpp"
#include "server/application.hpp"
#include "server/commands/bundle_file.hpp"
#include "server/commands/commands.hpp"
#include "server/commands/frame_files.hpp"
#include "server/commands/render_options.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kGlbMagic = "glTF";
constexpr const char* kModelPart = "model";
constexpr const char* kEnvironmentPart = "environment";

struct Arguments {
  std::string input, output;
  std::optional<std::string> environment;  // a file or the name of a built-in
  RenderOptions options;
  Config config;  // device, determinism, limits
  int repeat = 1;
  bool strict = false;
};

// The request and what it refers to. A file: reference means the folder of the file it stands in.
struct Job {
  std::string document;
  std::map<std::string, Blob> parts;
  fs::path root = ".";
  bool document_is_ours = false;  // made from the options, so they need not be applied to it
  std::optional<BundleFile> bundle = {};
};

bool on_terminal() {
  return ::isatty(STDERR_FILENO) == 1;
}

void name_environment(const Arguments& arguments, RenderOptions& options, Job& job) {
  if (!arguments.environment) return;
  const std::string& name = *arguments.environment;
  if (fs::is_regular_file(name)) {
    job.parts[kEnvironmentPart] = Blob(read_file(name, arguments.config.max_file_bytes));
    options.environment = fmt::format("part:{}", kEnvironmentPart);
  } else {
    options.environment = name.starts_with("builtin:") ? name : "builtin:" + name;
  }
}

// The name of the output says which format it has, unless that was said; and what holds a sequence.
void name_format(const Arguments& arguments, RenderOptions& options) {
  if (FrameFiles::parse(arguments.output) || fs::path(arguments.output).extension() == ".zip")
    options.container = "zip";
  if (options.format) return;
  const std::string extension = fs::path(arguments.output).extension();
  for (const api::FormatRow& row : api::kFormats)
    if (extension.substr(std::min<std::size_t>(1, extension.size())) == row.name) options.format = row.name;
  if (extension == ".jpg") options.format = "jpeg";
  if (extension == ".apng") options.format = "png";
}

Job make_job(const Arguments& arguments, const RenderOptions& options, Job job) {
  const fs::path input = arguments.input;
  if (input.extension() == ".zip" && fs::is_regular_file(input))
    job.bundle = BundleFile::read(Blob(read_file(input, arguments.config.max_file_bytes)));
  if (job.bundle) {
    job.document = job.bundle->document;
    job.parts.merge(std::map(job.bundle->parts));
    return job;
  }
  if (arguments.input != "-") job.root = input.has_parent_path() ? input.parent_path() : fs::path(".");
  if (arguments.input != "-" && is_model_name(input.string())) {
    if (!fs::is_regular_file(input))
      fail(ErrorCode::kNotFound, fmt::format("there is no file {}", arguments.input));
    job.document = request_document(options, "file:" + input.filename().string());
    job.document_is_ours = true;
    return job;
  }
  std::string content = read_input(arguments.input, arguments.config.max_file_bytes);
  const auto bytes = std::as_bytes(std::span(content));
  const bool is_other_model = model_format(bytes, arguments.input) != ModelFormat::kGltf;
  if (content.starts_with(kGlbMagic) || is_other_model || is_zip(bytes)) {
    job.parts[kModelPart] = Blob(std::move(content));
    job.document = request_document(options, fmt::format("part:{}", kModelPart));
    job.document_is_ours = true;
  } else {
    job.document = std::move(content);
  }
  return job;
}

RenderSpec make_spec(const Arguments& arguments, const RenderOptions& options, const Job& job,
                     FileAssets& files) {
  const AssetResolver assets(files, job.parts, ImportLimits{});
  const api::RequestLimits limits = request_limits(arguments.config);
  OutputFormat format = OutputFormat::kPng;
  for (const api::FormatRow& row : api::kFormats)
    if (options.format == row.name) format = row.format;
  RenderSpec spec = api::parse_render_request(job.document, assets, limits, format);
  if (!job.document_is_ours) {
    apply_options(options, api::parse_render_request(request_document(options, {}), assets, limits), spec);
  }
  spec.strict = spec.strict || arguments.strict;
  return spec;
}

void tell_begin(const RenderSpec& spec) {
  const OutputSpec& out = spec.output;
  if (on_terminal()) {
    fmt::print(stderr, "drawing {} x {}, {} samples\n", out.width, out.height, out.samples);
  } else {
    log::info("render.begin", {{"width", out.width}, {"height", out.height}, {"samples", out.samples}});
  }
}

void tell_picture(const Rendered& rendered, double total_ms) {
  const StageTimes& t = rendered.times;
  const api::StoredRender& image = *rendered.image;
  if (!on_terminal()) {
    log::info("render.done", {{"bytes", image.bytes.size()},
                              {"exposure_ev", image.exposure_ev},
                              {"total_ms", total_ms},
                              {"queue_ms", t.queue_ms},
                              {"decode_ms", t.decode_ms},
                              {"bake_ms", t.bake_ms},
                              {"upload_ms", t.upload_ms},
                              {"draw_ms", t.draw_ms},
                              {"readback_ms", t.readback_ms},
                              {"encode_ms", t.encode_ms}});
    return;
  }
  fmt::print(stderr,
             "{} bytes, exposed by {} stops, in {:.1f} ms: decode {:.1f}, bake {:.1f}, upload {:.1f}, draw "
             "{:.1f}, read back "
             "{:.1f}, encode {:.1f}\n",
             image.bytes.size(), image.exposure_ev, total_ms, t.decode_ms, t.bake_ms, t.upload_ms, t.draw_ms,
             t.readback_ms, t.encode_ms);
}

void tell_notes(const std::vector<Note>& notes) {
  for (const Note& note : notes) {
    if (on_terminal()) {
      fmt::print(stderr, "note: {}: {}{}\n", note.code, note.message,
                 note.pointer.empty() ? "" : " (at " + note.pointer + " of the model)");
    } else {
      log::info("render.note", {{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
    }
  }
}

void write_output(const std::string& output, std::string_view bytes) {
  if (output != "-") return write_file_atomically(output, bytes);
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() || std::fflush(stdout) != 0) {
    fail(ErrorCode::kStorage, "could not write to standard output");
  }
}

void tell_frame(int done, int frames) {
  if (on_terminal()) {
    fmt::print(stderr, "\rframe {} of {}{}", done, frames, done == frames ? "\n" : "");
  } else {
    log::info("render.frame", {{"done", done}, {"frames", frames}});
  }
}

std::vector<Note> write_frames(const FrameFiles& files, RenderService& service, const RenderSpec& spec,
                               const Deadline& deadline) {
  std::vector<Note> notes;
  service.render_frames(spec, deadline, [&](int frame, int frames, const api::StoredRender& image) {
    write_file_atomically(files.name_of(frame), image.bytes);
    for (const Note& note : image.notes)
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
    tell_frame(frame + 1, frames);
  });
  return notes;
}

void tell_bundle(const BundleFile& bundle, std::string_view picture, const std::string& fingerprint) {
  const std::string verdict = bundle.verdict(picture, fingerprint);
  if (on_terminal()) {
    fmt::print(stderr, "{}\n", verdict);
  } else {
    log::info("render.bundle", {{"verdict", verdict}});
  }
}

int render(Arguments arguments) {
  if (on_terminal()) log::set_level(log::Level::kWarning);
  RenderOptions options = arguments.options;
  Job named;
  name_environment(arguments, options, named);
  name_format(arguments, options);
  const Job job = make_job(arguments, options, std::move(named));
  if (job.bundle && job.bundle->about.is_exact) arguments.config.determinism = "exact";
  gl::apply_determinism(arguments.config.determinism == "exact" ? gl::Determinism::kExact
                                                                : gl::Determinism::kFast);

  Engine engine(arguments.config, {job.root});
  const RenderSpec spec = make_spec(arguments, options, job, engine.files);
  tell_begin(spec);
  const Deadline deadline(std::chrono::milliseconds(arguments.config.timeout_ms));
  if (const auto files = FrameFiles::parse(arguments.output); files && spec.output.sequence) {
    tell_notes(write_frames(*files, engine.service, spec, deadline));
    return kDone;
  }
  Rendered rendered;
  for (int i = 0; i < arguments.repeat; ++i) {
    const auto start = Clock::now();
    rendered = engine.service.render(spec, deadline, [](const RenderProgress& now) {
      if (now.stage.empty()) tell_frame(now.frames_done, now.frames);
    });
    tell_picture(rendered, std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  tell_notes(rendered.image->notes);
  if (job.bundle) tell_bundle(*job.bundle, rendered.image->bytes, engine.service.fingerprint());
  write_output(arguments.output, rendered.image->bytes);
  return kDone;
}

void add_options(CLI::App& command, Arguments& to) {
  RenderOptions& options = to.options;
  command
      .add_option(
          "input", to.input,
          "REQUEST.json, MODEL.glb, .gltf, .obj, .stl, .ply or .zip, a bundle, or - for standard input")
      ->required();
  command
      .add_option("-o,--output", to.output,
                  "OUT.png, .exr, .jpg or .webp, of a sequence also .webm, .zip or frame_%04d.png; - for "
                  "standard output")
      ->required();
  command.add_option("--environment", to.environment,
                     "an .hdr or .exr file, or the name of a built-in environment");
  command.add_option("--rotation", options.rotation_degrees, "turn of the environment about +Y, degrees");
  command.add_option("--scene", options.gltf_scene, "index of one of a glTF's scenes; else its default")
      ->check(CLI::Range(0, 1'000'000));
  command.add_option("--variant", options.variant, "one of the model's sets of materials");
  command.add_option("--animation", options.animation, "one of the model's animations, by name or index");
  command.add_option("--time", options.time_seconds, "of the animation, s; of the first if none is named");
  command
      .add_option(
          "--frames", options.frames,
          "a sequence of so many pictures of the animation or the turntable; OUT is an animated .webp "
          "or .png, a .webm, a .zip, or a name such as frame_%04d.png for single files")
      ->check(CLI::Range(2, 100'000));
  command.add_option("--fps", options.frames_per_second, "frames per second of a sequence; 24 if not said")
      ->check(CLI::Range(0.1, 120.0));
  command
      .add_option("--turntable", options.turntable_degrees,
                  "degrees that the camera goes round over all frames of a sequence")
      ->check(CLI::Range(-36'000.0, 36'000.0));
  command.add_option("--up-axis", options.up_axis, "of an OBJ, STL or PLY file: y or z")
      ->check(CLI::IsMember({"y", "z"}));
  command.add_option("--shading-model", options.shading_model, "pbr, schlick-beckmann, blinn-phong or phong");
  command.add_option("--background", options.background, "environment, transparent or #rrggbb");
  command.add_option("--background-blur", options.blur_degrees, "of the environment seen, degrees");
  command.add_flag("--ground", options.ground, "a ground that shows the scene's shadow");
  command.add_option("--visibility", options.visibility,
                     "whether the scene keeps the environment's light from itself: auto, on, off");
  command.add_option("--sun", options.sun, "suns of the environment: auto, keep, or extract them as lights");
  command.add_option("--width", options.width, "px");
  command.add_option("--height", options.height, "px");
  command.add_option("--azimuth", options.azimuth_degrees,
                     "of the camera, degrees: 0 looks from +Z, 90 from +X");
  command.add_option("--elevation", options.elevation_degrees, "of the camera, degrees towards +Y");
  command.add_option("--exposure", options.exposure_ev, "stops");
  command.add_option("--ev100", options.ev100, "exposure of a physical camera, for radiance in cd/m2");
  command.add_option("--aperture", options.aperture, "the same by f-number, with --shutter");
  command.add_option("--shutter", options.shutter_seconds, "s, with --aperture");
  command.add_option("--iso", options.iso, "with --aperture and --shutter");
  command.add_flag("--auto-exposure", options.auto_exposure, "brings the picture's mean to mid grey");
  command.add_option("--f-stop", options.f_stop, "of a lens that blurs what is out of focus; needs samples");
  command.add_option("--focus-distance", options.focus_distance_m,
                     "m; else the middle of the scene is sharp");
  command.add_option("--motion-blur", options.motion_blur_seconds,
                     "s of the animation that the shutter is open; needs samples");
  command.add_option("--bloom", options.bloom_intensity, "share of what is bright that spreads round it");
  command.add_option("--pixel-filter", options.pixel_filter, "box, gaussian, blackman-harris or mitchell");
  command.add_option("--tone-map", options.tone_map, "pbr-neutral, aces, agx, reinhard, linear or none");
  command.add_option("--white-balance", options.white_balance_kelvin, "kelvin of the light that looks white");
  command.add_option("--tint", options.white_balance_tint, "towards magenta, or green if negative");
  command.add_option("--contrast", options.contrast, "exponent about mid grey");
  command.add_option("--saturation", options.saturation, "0: grey, 1: as it is");
  command
      .add_option("--layers", options.layers,
                  "of an EXR, beside the picture: depth,normal,albedo,cryptoObject ...; the schema has all")
      ->delimiter(',');
  command.add_option("--show", options.show, "one of them in place of the picture");
  command.add_option("--format", options.format,
                     "png, exr, jpeg, webp or webm; else the ending of OUT says it");
  command.add_option("--bit-depth", options.bit_depth, "of a PNG, 8 or 16");
  command.add_option("--exr-type", options.exr_type, "half or float");
  command.add_option("--exr-compression", options.exr_compression, "none, zip, piz or dwaa");
  command.add_option("--compression-quality", options.compression_quality,
                     "of JPEG, WebP and WebM, 1 to 100");
  command.add_flag("--lossless", options.lossless, "of a WebP");
  command.add_flag("--dither", options.dither, "rounds to 8 bits by a pattern: no bands in gradients");
  CLI::Option* quality =
      command.add_option("--quality", options.quality, "draft, standard, high or reference");
  command.add_option("--samples", options.samples, "sub-frames, instead of a quality")->excludes(quality);
  command.add_option("--repeat", to.repeat, "draw so many times and tell each time")
      ->check(CLI::Range(1, 1'000'000));
  command.add_flag("--strict", to.strict, "fail when anything cannot be drawn as asked");
  command.add_option("--device", to.config.device, "as of serve")->envname("FURNACE_DEVICE");
  command.add_option("--determinism", to.config.determinism, "fast or exact, as of serve")
      ->envname("FURNACE_DETERMINISM")
      ->check(CLI::IsMember({"fast", "exact"}));
  add_decoder_option(command, to.config);
  command.add_option("--shader-dir", to.config.shader_dir, "as of serve")->envname("FURNACE_SHADER_DIR");
}

}  // namespace

Command render_command(CLI::App& root) {
  CLI::App* command = root.add_subcommand("render", "Draws one picture");
  const auto arguments = std::make_shared<Arguments>();
  arguments->config = local_config();
  add_options(*command, *arguments);
  return {command, [arguments] { return render(*arguments); }};
}

}  // namespace furnace
