#include "server/settings.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace furnace {
namespace {

using Unit = SettingUnit;

constexpr std::int64_t kMiB = 1ll << 20;
constexpr std::int64_t kGiB = 1ll << 30;
constexpr std::int64_t kSecond = 1000;  // ms

constexpr Setting text(std::string_view name, std::string Config::*member, Unit unit, std::string_view help,
                       std::string_view choices = {}) {
  return {name, member, unit, 0, 0, choices, help};
}
template <class Number>
constexpr Setting number(std::string_view name, Number Config::*member, Unit unit, std::int64_t min,
                         std::int64_t max, std::string_view help) {
  return {name, member, unit, min, max, {}, help};
}

constexpr std::array kSettings = {
    text("listen", &Config::listen, Unit::kAddress, "address of the API; port 0 takes a free one"),
    text("admin-listen", &Config::admin_listen, Unit::kAddress,
         "second address with health and metrics only, answered whatever the load; metrics then leave the "
         "main one"),
    text("device", &Config::device, Unit::kText,
         "auto, software, EGL device indices or PCI addresses (several: \"0,1\"); see furnace doctor"),
    number("contexts", &Config::contexts, Unit::kCount, 0, 64,
           "GL contexts, a thread each, over the devices in turn; 0: one on each"),
    number("context-renders", &Config::context_renders, Unit::kCount, 0, 1'000'000'000,
           "pictures after which a context is made anew; 0: never"),
    number("context-age", &Config::context_age_ms, Unit::kDuration, 0, 365ll * 24 * 3600 * kSecond,
           "time after which a context is made anew; 0: never"),
    number("context-memory", &Config::context_process_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "memory of the process beyond which a context is made anew, once a minute at most; 0: never"),
    text("determinism", &Config::determinism, Unit::kChoice,
         "fast: same bytes on one machine; exact: software, same bytes on any x86-64 with the same Mesa",
         "fast|exact"),
    text("shader-dir", &Config::shader_dir, Unit::kFolder,
         "read shaders from here instead of the binary (development)"),
    Setting{"assets",
            &Config::assets,
            Unit::kFolder,
            0,
            0,
            {},
            "folder that file: references may read from; may be given more than once (in one value: "
            "separated by ':')"},
    text("data", &Config::data, Unit::kText,
         "folder, made when missing, that keeps baked and named environments; without it they end with the "
         "process"),
    text("log-level", &Config::log_level, Unit::kChoice, "least level that is logged",
         "debug|info|warning|error|off"),

    number("seats", &Config::seats, Unit::kCount, 0, 1024, "renders worked on at once; 0: cores + contexts"),
    number("queue", &Config::queue, Unit::kCount, 0, 4096,
           "renders that may wait for a seat; more are answered 429"),
    number("cpu-threads", &Config::cpu_threads, Unit::kCount, 0, 1024,
           "threads that decode, bake and encode; 0: cores"),
    number("timeout", &Config::timeout_ms, Unit::kDuration, 1, 3600 * kSecond,
           "time of one request, the wait for a seat included; then 504"),
    number("ready-timeout", &Config::ready_timeout_ms, Unit::kDuration, 10, 600 * kSecond,
           "time of the picture that /readyz draws"),
    number("drain-timeout", &Config::drain_timeout_ms, Unit::kDuration, 0, 3600 * kSecond,
           "after SIGTERM, time for requests at work to end"),
    number("gl-watchdog", &Config::gl_watchdog_ms, Unit::kDuration, 0, 3600 * kSecond,
           "how long a drawing may outlive its request's time; then the driver hangs, and the process ends "
           "with status 3 for "
           "another to take its place; 0: never"),

    number("job-threads", &Config::job_threads, Unit::kCount, 1, 64, "jobs that are worked on at once"),
    number("job-queue", &Config::job_queue, Unit::kCount, 0, 1'000'000,
           "jobs that may wait; more are answered 429"),
    number("job-timeout", &Config::job_timeout_ms, Unit::kDuration, 1, 24 * 3600 * kSecond,
           "time of one job, once it has begun"),
    number("job-deadline", &Config::job_deadline_ms, Unit::kDuration, 1, 365ll * 24 * 3600 * kSecond,
           "time of one job from when it was asked for, its wait included; then it has failed with 504"),
    number("job-ttl", &Config::job_ttl_ms, Unit::kDuration, kSecond, 365ll * 24 * 3600 * kSecond,
           "how long a finished job and its result are kept"),
    number("job-store", &Config::job_bytes, Unit::kBytes, kMiB, 1024 * kGiB,
           "requests and results of jobs below --data; without it in memory, 256MiB at most"),
    number("event-streams", &Config::event_streams, Unit::kCount, 0, 1024,
           "streams of a job's events at once; each holds a thread"),

    text("webhook-allow", &Config::webhook_allow, Unit::kText,
         "hosts that may be told of a job's end, separated by ',': example.com, *.example.com, "
         "https://example.com:8443; '*': all; networks in which they may lie beside public ones: 10.0.0.0/8; "
         "none: "
         "no webhooks"),
    text("webhook-secrets-file", &Config::webhook_secrets_file, Unit::kText,
         "file of lines NAME:whsec_BASE64, not to be read by others; all of them sign each webhook (furnace "
         "hash-key --webhook)"),
    number("webhook-threads", &Config::webhook_threads, Unit::kCount, 1, 256,
           "webhooks that are delivered at once, two to one host at most"),
    number("webhook-queue", &Config::webhook_queue, Unit::kCount, 0, 10'000'000,
           "webhooks not yet delivered, those of waiting jobs too; more are answered 429"),
    number("webhook-attempts", &Config::webhook_attempts, Unit::kCount, 1, 100,
           "how often one webhook is tried"),
    number("webhook-timeout", &Config::webhook_timeout_ms, Unit::kDuration, 1, 600 * kSecond,
           "time of one attempt"),
    number("webhook-pause", &Config::webhook_pause_ms, Unit::kDuration, 1, 24 * 3600 * kSecond,
           "wait before the second attempt, then three times as long each time, up to 6 hours"),
    number("webhook-max-age", &Config::webhook_max_age_ms, Unit::kDuration, 1, 365ll * 24 * 3600 * kSecond,
           "how long after a job's end it is still told of"),

    text("remote-allow", &Config::remote_allow, Unit::kText,
         "hosts that https: references may be fetched from, as webhook-allow; none: nothing is fetched"),
    number("remote-max-bytes", &Config::remote_max_bytes, Unit::kBytes, 1024, 64 * kGiB,
           "largest file that is fetched; more is 413"),
    number("remote-max-request", &Config::remote_request_bytes, Unit::kBytes, 1024, 64 * kGiB,
           "files that are fetched for one request, together; more is 413"),
    number("remote-timeout", &Config::remote_timeout_ms, Unit::kDuration, 1, 600 * kSecond,
           "time of one fetch, redirects included; then 504"),
    number("remote-fetches", &Config::remote_fetches, Unit::kCount, 1, 1024, "fetches at once; others wait"),
    number("remote-freshness", &Config::remote_freshness_ms, Unit::kDuration, 1, 24 * 3600 * kSecond,
           "how long a fetched file is used without asking again"),
    number("remote-cache", &Config::remote_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "fetched files kept in memory"),
    text("outbound-ca-file", &Config::outbound_ca_file, Unit::kText,
         "certificates (PEM) that fetches and webhooks trust, in place of the system's"),

    number("max-body", &Config::max_body_bytes, Unit::kBytes, 1024, kGiB,
           "largest request body; more is 413"),
    number("max-bodies", &Config::max_bodies_bytes, Unit::kBytes, 1024, 64 * kGiB,
           "largest sum of all request bodies held at once; more is 429"),
    number("max-parts", &Config::max_parts, Unit::kCount, 1, 4096, "parts of one multipart request"),
    number("max-batch", &Config::max_batch, Unit::kCount, 1, 10'000, "renders of one batch"),
    number("max-bundle", &Config::max_bundle_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "files of a request that POST /v1/bundles packs; more are 413"),
    number("max-json", &Config::max_json_bytes, Unit::kBytes, 1024, 256 * kMiB, "largest request document"),
    number("max-side", &Config::max_side_px, Unit::kCount, 1, 16384,
           "largest width or height of a picture, px"),
    number("max-area", &Config::max_area_px, Unit::kCount, 1, 256ll << 20,
           "largest width * height of a picture, px"),
    number("max-samples", &Config::max_samples, Unit::kCount, 1, 4096, "most samples a request may ask for"),
    number("max-layers", &Config::max_layer_bytes, Unit::kBytes, 0, 64 * kGiB,
           "film layers of one picture, as they are drawn"),
    number("max-frames", &Config::max_frames, Unit::kCount, 2, 100'000, "most frames of one sequence"),
    number("max-sequence", &Config::max_sequence_px, Unit::kCount, 1, 1ll << 40,
           "largest width * height * frames of a sequence, px"),

    text("decoder-sandbox", &Config::decoder_sandbox, Unit::kChoice,
         "images, compressed meshes and models other than glTF are decoded in child processes that may do "
         "nothing else; require: do "
         "not start where the system cannot confine them; prefer: then do without, and warn; off: decode in "
         "the server's own process",
         "require|prefer|off"),
    number("decoders", &Config::decoders, Unit::kCount, 0, 1024, "child processes that decode; 0: cores"),
    number("decoder-timeout", &Config::decoder_timeout_ms, Unit::kDuration, 1, 3600 * kSecond,
           "time of one file or mesh; more is 422"),
    number("decoder-memory", &Config::decoder_memory_bytes, Unit::kBytes, 64 * kMiB, 1024 * kGiB,
           "memory of one child while it decodes; more is 422"),
    number("decoder-jobs", &Config::decoder_jobs, Unit::kCount, 1, 1'000'000'000,
           "files and meshes after which a child is replaced; 1: a child for each"),
    number("decoder-bytes", &Config::decoder_bytes, Unit::kBytes, 1, 1024 * kGiB,
           "bytes of files after which a child is replaced"),

    text("presets", &Config::presets, Unit::kFolder,
         "folder of NAME.json, render requests that GET /v1/render?preset=NAME draws"),
    text("presets-only", &Config::presets_only, Unit::kChoice,
         "on: GET /v1/render draws presets only, with the keys over them that each lists as furnace:open",
         "off|on"),
    number("image-max-age", &Config::image_max_age_ms, Unit::kDuration, 0, 365ll * 24 * 3600 * kSecond,
           "how long an answer of GET /v1/render may be shown without asking again"),
    number("max-url", &Config::max_url_bytes, Unit::kBytes, 64, 8192,
           "longest path and query of a URL; more is 414"),
    text("url-keys-file", &Config::url_keys_file, Unit::kText,
         "file of lines KEYID:HEX-SECRET, not to be read by others; GET /v1/render then takes signed URLs "
         "only (furnace "
         "sign-url)"),
    text("api-keys-file", &Config::api_keys_file, Unit::kText,
         "file of lines NAME:SCOPES:HEX-SHA256-OF-KEY[:RATE-PER-MINUTE[:RENDERS-PER-DAY[:ASSET-BYTES]]]; all "
         "but health and "
         "documents then needs a key (furnace hash-key)"),
    text("allow-anonymous", &Config::allow_anonymous, Unit::kChoice,
         "on: listen to other machines even without API keys", "off|on"),
    text("tls-certificate", &Config::tls_certificate, Unit::kText,
         "file of the certificate and those that lead to its root, PEM; listen then speaks HTTPS; read again "
         "on SIGHUP"),
    text("tls-key", &Config::tls_key, Unit::kText,
         "file of the certificate's key, PEM without a passphrase, not to be read by others"),
    number("hsts-max-age", &Config::hsts_max_age_ms, Unit::kDuration, 0, 2 * 365ll * 24 * 3600 * kSecond,
           "with TLS: for how long browsers are told to use nothing else for this host; 0: not told"),
    text("cors-origins", &Config::cors_origins, Unit::kText,
         "origins whose pages may call the API from a browser, separated by ','; '*': all"),

    number("max-connections", &Config::max_connections, Unit::kCount, 1, 65536,
           "connections that may wait for a thread; more are refused"),
    number("keep-alive", &Config::keep_alive_ms, Unit::kDuration, 0, 600 * kSecond,
           "how long an idle connection is kept (it holds a thread)"),
    number("header-timeout", &Config::header_timeout_ms, Unit::kDuration, 10, 600 * kSecond,
           "time for a request's line and headers to arrive"),
    number("io-timeout", &Config::io_timeout_ms, Unit::kDuration, 10, 600 * kSecond,
           "longest standstill while a body is sent or received"),

    number("scene-cache", &Config::scene_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "parsed scenes kept in memory"),
    number("bake-cache", &Config::bake_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "baked environments kept in memory"),
    number("background-cache", &Config::background_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "backgrounds that are blurred, or of another environment, kept in memory"),
    number("map-cache", &Config::map_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "maps of named environments kept in memory for download"),
    number("disk-cache", &Config::disk_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "baked environments, and such backgrounds, kept below --data"),
    number("environments", &Config::environments_bytes, Unit::kBytes, 0, 64 * kGiB,
           "files of all named environments together"),
    number("gpu-cache", &Config::gpu_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "meshes, textures and environments kept on the GPU"),
    number("file-cache", &Config::file_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "files below --assets kept in memory"),
    number("max-file", &Config::max_file_bytes, Unit::kBytes, 1024, 1024 * kGiB,
           "largest file below --assets"),
    number("render-cache", &Config::render_cache_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "finished renders, with their reports, kept in memory"),
    number("render-disk-cache", &Config::render_disk_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "finished renders kept below --data"),

    number("max-asset", &Config::max_asset_bytes, Unit::kBytes, 1024, 64 * kGiB,
           "largest file that may be uploaded to /v1/assets; more is 413"),
    number("asset-store", &Config::asset_store_bytes, Unit::kBytes, 0, 1024 * kGiB,
           "uploaded files kept below --data, those not used for longest go first"),
    number("asset-ttl", &Config::asset_ttl_ms, Unit::kDuration, 0, 3660ll * 24 * 3600 * kSecond,
           "uploaded files not used for so long are removed; 0: never"),
    number("partial-ttl", &Config::partial_ttl_ms, Unit::kDuration, 0, 365ll * 24 * 3600 * kSecond,
           "uploads in several requests to which nothing came for so long are removed; 0: never"),
};

struct Suffix {
  std::string_view text;
  std::int64_t factor;
};
constexpr std::array kByteSuffixes = {Suffix{"", 1}, Suffix{"KiB", 1 << 10}, Suffix{"MiB", kMiB},
                                      Suffix{"GiB", kGiB}};
constexpr std::array kTimeSuffixes = {Suffix{"ms", 1}, Suffix{"s", kSecond}, Suffix{"min", 60 * kSecond}};
constexpr std::array kCountSuffixes = {Suffix{"", 1}};

std::span<const Suffix> suffixes_of(Unit unit) {
  if (unit == Unit::kBytes) return kByteSuffixes;
  if (unit == Unit::kDuration) return kTimeSuffixes;
  return kCountSuffixes;
}

std::optional<std::int64_t> parse_number(std::string_view text, Unit unit) {
  std::int64_t value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{}) return std::nullopt;
  const std::string_view suffix(end, text.data() + text.size() - end);
  for (const Suffix& known : suffixes_of(unit)) {
    std::int64_t scaled = 0;
    if (suffix == known.text && !__builtin_mul_overflow(value, known.factor, &scaled)) return scaled;
  }
  return std::nullopt;
}

// In the largest suffix that divides it.
std::string number_text(std::int64_t value, Unit unit) {
  const auto suffixes = suffixes_of(unit);
  const Suffix* best = &suffixes.front();
  for (const Suffix& suffix : suffixes) {
    if (value != 0 && value % suffix.factor == 0) best = &suffix;
  }
  return fmt::format("{}{}", value / best->factor, best->text);
}

std::string_view number_form(Unit unit) {
  if (unit == Unit::kBytes) return "a size such as 64MiB";
  if (unit == Unit::kDuration) return "a time such as 30s or 250ms";
  return "a whole number";
}

bool is_choice(std::string_view value, std::string_view choices) {
  while (!choices.empty()) {
    const std::size_t bar = std::min(choices.find('|'), choices.size());
    if (choices.substr(0, bar) == value) return true;
    choices.remove_prefix(std::min(bar + 1, choices.size()));
  }
  return false;
}

std::string check_folder(std::string_view path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return {};
  return fmt::format("'{}' is not a folder", path);
}

std::string check_text(const Setting& setting, std::string_view value) {
  switch (setting.unit) {
    case Unit::kChoice:
      if (is_choice(value, setting.choices)) return {};
      return fmt::format("'{}' is not one of {}", value, setting.choices);
    case Unit::kAddress:
      if (value.empty() || parse_address(value)) return {};
      return fmt::format("'{}' is not an address such as 127.0.0.1:8080", value);
    case Unit::kFolder:
      return value.empty() ? std::string{} : check_folder(value);
    default:
      return {};
  }
}

std::string assign_list(std::vector<std::string>& list, std::string_view value) {
  while (!value.empty()) {
    const std::size_t end = std::min(value.find(':'), value.size());
    const std::string_view item = value.substr(0, end);
    if (!item.empty()) {
      if (std::string problem = check_folder(item); !problem.empty()) return problem;
      list.emplace_back(item);
    }
    value.remove_prefix(std::min(end + 1, value.size()));
  }
  return {};
}

}  // namespace

std::span<const Setting> all_settings() {
  return kSettings;
}

const Setting* find_setting(std::string_view name) {
  const auto found = std::ranges::find(kSettings, name, &Setting::name);
  return found == kSettings.end() ? nullptr : &*found;
}

std::string environment_name(const Setting& setting) {
  std::string name = "FURNACE_";
  for (const char c : setting.name) name += c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return name;
}

std::string assign(const Setting& setting, std::string_view text, Config& config) {
  if (const auto* member = std::get_if<std::string Config::*>(&setting.member)) {
    std::string problem = check_text(setting, text);
    if (problem.empty()) config.** member = std::string(text);
    return problem;
  }
  if (const auto* member = std::get_if<std::vector<std::string> Config::*>(&setting.member)) {
    return assign_list(config.**member, text);
  }
  const std::optional<std::int64_t> value = parse_number(text, setting.unit);
  if (!value) return fmt::format("'{}' is not {}", text, number_form(setting.unit));
  if (*value < setting.min || *value > setting.max) {
    return fmt::format("{} is outside of {} to {}", text, number_text(setting.min, setting.unit),
                       number_text(setting.max, setting.unit));
  }
  if (const auto* member = std::get_if<int Config::*>(&setting.member))
    config.** member = static_cast<int>(*value);
  if (const auto* member = std::get_if<std::int64_t Config::*>(&setting.member)) config.** member = *value;
  return {};
}

std::optional<std::int64_t> parse_size(std::string_view text) {
  return parse_number(text, Unit::kBytes);
}

std::string value_text(const Setting& setting, const Config& config) {
  if (const auto* member = std::get_if<std::string Config::*>(&setting.member)) return config.**member;
  if (const auto* member = std::get_if<int Config::*>(&setting.member))
    return number_text(config.**member, setting.unit);
  if (const auto* member = std::get_if<std::int64_t Config::*>(&setting.member)) {
    return number_text(config.**member, setting.unit);
  }
  return fmt::format("{}",
                     fmt::join(config.*std::get<std::vector<std::string> Config::*>(setting.member), ":"));
}

}  // namespace furnace
