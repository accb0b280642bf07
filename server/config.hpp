// What can be set, from where, and what it came to. The table of all settings is settings.cpp.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace furnace {

// Threads: a value. Ranges and help stand in the table, defaults here.
struct Config {
  std::string listen = "127.0.0.1:8080";
  std::string admin_listen;     // empty: health and metrics are on the main listener only
  std::string device = "auto";  // as RendererConfig::gl
  int contexts = 0;             // 0: one on each device
  std::int64_t context_renders = 100'000;
  std::int64_t context_age_ms = 24ll * 3600 * 1000;
  std::int64_t context_process_bytes = 0;
  std::string determinism = "fast";
  std::string shader_dir;
  std::vector<std::string> assets;  // roots of "file:" references
  std::string data;                 // folder for what outlives the process; empty: nothing does
  std::string log_level = "info";

  int seats = 0;  // 0: one per core and one for each context
  int queue = 16;
  int cpu_threads = 0;               // 0: one per core
  std::int64_t timeout_ms = 30'000;  // of one request, waiting included
  std::int64_t ready_timeout_ms = 10'000;
  std::int64_t drain_timeout_ms = 20'000;
  std::int64_t gl_watchdog_ms = 60'000;

  int job_threads = 1;
  int job_queue = 1000;
  std::int64_t job_timeout_ms = 600'000;              // of one job, once it has begun
  std::int64_t job_deadline_ms = 24ll * 3600 * 1000;  // of one job, its wait included
  std::int64_t job_ttl_ms = 24ll * 3600 * 1000;
  std::int64_t job_bytes = 4096ll << 20;
  int event_streams = 8;

  std::string webhook_allow;  // as AllowList; empty: none are called
  std::string webhook_secrets_file;
  int webhook_threads = 8;
  int webhook_queue = 10'000;
  int webhook_attempts = 10;
  std::int64_t webhook_timeout_ms = 10'000;  // of one attempt
  std::int64_t webhook_pause_ms = 5'000;     // before the second attempt
  std::int64_t webhook_max_age_ms = 24ll * 3600 * 1000;

  std::string remote_allow;                         // as AllowList; empty: nothing is fetched
  std::int64_t remote_max_bytes = 64ll << 20;       // of one file
  std::int64_t remote_request_bytes = 256ll << 20;  // of all files of one request
  std::int64_t remote_timeout_ms = 5'000;           // of one file
  int remote_fetches = 8;                           // at once
  std::int64_t remote_freshness_ms = 60'000;
  std::int64_t remote_cache_bytes = 256ll << 20;
  std::string outbound_ca_file;  // empty: the system's certificates

  std::int64_t max_body_bytes = 64ll << 20;
  std::int64_t max_bodies_bytes = 512ll << 20;
  int max_parts = 64;
  int max_batch = 256;
  std::int64_t max_bundle_bytes = 512ll << 20;
  std::int64_t max_json_bytes = 4ll << 20;
  int max_side_px = 4096;
  std::int64_t max_area_px = 16ll << 20;
  int max_samples = 64;
  std::int64_t max_layer_bytes = 512ll << 20;
  int max_frames = 360;
  std::int64_t max_sequence_px = 128ll << 20;

  std::string decoder_sandbox = "prefer";
  int decoders = 0;                          // 0: one per core
  std::int64_t decoder_timeout_ms = 20'000;  // of one file
  std::int64_t decoder_memory_bytes = 2048ll << 20;
  int decoder_jobs = 200;
  std::int64_t decoder_bytes = 4096ll << 20;

  std::string presets;  // folder of the presets of image URLs; empty: there are none
  std::string presets_only = "off";
  std::int64_t image_max_age_ms = 3600'000;
  std::int64_t max_url_bytes = 8192;

  std::string url_keys_file;  // empty: image URLs need no signature
  std::string api_keys_file;  // empty: whoever reaches the server may use it
  std::string cors_origins;   // separated by commas
  std::string allow_anonymous = "off";
  std::string tls_certificate, tls_key;  // files; empty: plain HTTP
  std::int64_t hsts_max_age_ms = 365ll * 24 * 3600 * 1000;

  int max_connections = 256;           // waiting for a thread; those beyond are refused
  std::int64_t keep_alive_ms = 1'000;  // an idle connection holds a thread
  std::int64_t header_timeout_ms = 5'000;
  std::int64_t io_timeout_ms = 10'000;

  std::int64_t scene_cache_bytes = 256ll << 20;
  std::int64_t bake_cache_bytes = 512ll << 20;
  std::int64_t background_cache_bytes = 512ll << 20;
  std::int64_t map_cache_bytes = 256ll << 20;
  std::int64_t disk_cache_bytes = 4096ll << 20;
  std::int64_t environments_bytes = 512ll << 20;
  std::int64_t gpu_cache_bytes = 1024ll << 20;
  std::int64_t file_cache_bytes = 256ll << 20;
  std::int64_t max_file_bytes = 512ll << 20;
  std::int64_t render_cache_bytes = 256ll << 20;
  std::int64_t render_disk_bytes = 4096ll << 20;

  std::int64_t max_asset_bytes = 256ll << 20;
  std::int64_t asset_store_bytes = 4096ll << 20;
  std::int64_t asset_ttl_ms = 0;  // 0: for ever
  std::int64_t partial_ttl_ms = 24ll * 3600 * 1000;
};

using NamedValues =
    std::vector<std::pair<std::string, std::string>>;  // in order; a list setting may come more than once

struct ConfigSources {
  std::optional<std::string> file_text;  // key = value lines, "#" comments
  NamedValues environment;  // whole environment: names that do not begin with FURNACE_ are passed over
  NamedValues flags;        // names without dashes
};

struct LoadedConfig {
  Config config;
  std::map<std::string, std::string, std::less<>>
      origins;                        // setting -> "default", "file", "environment", "flag"
  std::vector<std::string> problems;  // not empty: do not start
  std::vector<std::string> warnings;
};

// defaults < file < environment < flags; all problems are told at once.
LoadedConfig load_config(const ConfigSources& sources);

// The effective values as a configuration file, each with its origin and help.
std::string print_config(const LoadedConfig& loaded);

struct Address {
  std::string host;
  int port = 0;  // 0: any free one
};
std::optional<Address> parse_address(std::string_view text);  // "127.0.0.1:8080", "[::1]:0", "localhost:80"
bool is_loopback(const Address& address);

}  // namespace furnace
