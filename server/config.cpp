#include "server/config.hpp"

#include <algorithm>
#include <charconv>
#include <set>

#include <fmt/format.h>

#include "server/cors.hpp"
#include "server/outbound_url.hpp"
#include "server/settings.hpp"
#include "server/field_text.hpp"

namespace furnace {
namespace {

constexpr std::string_view kSpace = " \t\r";

constexpr std::string_view kPrefix = "FURNACE_";
constexpr std::string_view kConfigVariable = "FURNACE_CONFIG";  // names the file; read by the command line

// Collects what one source says; a list setting of a higher source replaces that of a lower one.
class Layer {
 public:
  Layer(LoadedConfig& loaded, std::string_view origin) : loaded_(loaded), origin_(origin) {}

  void set(const Setting& setting, std::string_view said_as, std::string_view value) {
    if (seen_.insert(setting.name).second) clear_list(setting);
    if (const std::string problem = assign(setting, value, loaded_.config); !problem.empty()) {
      loaded_.problems.push_back(fmt::format("{}: {}", said_as, problem));
    }
    loaded_.origins[std::string(setting.name)] = origin_;
  }

 private:
  void clear_list(const Setting& setting) {
    if (const auto* list = std::get_if<std::vector<std::string> Config::*>(&setting.member)) {
      (loaded_.config.**list).clear();
    }
  }

  LoadedConfig& loaded_;
  std::string_view origin_;
  std::set<std::string_view> seen_;
};

void read_file_text(std::string_view text, LoadedConfig& loaded) {
  Layer layer(loaded, "file");
  for (int line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end), kSpace);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == '#') continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
      loaded.problems.push_back(
          fmt::format("configuration file, line {}: not of the form name = value", line_number));
      continue;
    }
    const std::string_view name = trimmed(line.substr(0, equals), kSpace);
    if (const Setting* setting = find_setting(name)) {
      layer.set(*setting, fmt::format("configuration file, line {}, {}", line_number, name),
                trimmed(line.substr(equals + 1), kSpace));
    } else {
      loaded.problems.push_back(
          fmt::format("configuration file, line {}: there is no setting '{}'", line_number, name));
    }
  }
}

void read_environment(const NamedValues& environment, LoadedConfig& loaded) {
  Layer layer(loaded, "environment");
  const auto settings = all_settings();
  for (const auto& [name, value] : environment) {
    if (!name.starts_with(kPrefix) || name == kConfigVariable) continue;
    const auto found = std::ranges::find(settings, name, environment_name);
    if (found == settings.end()) {
      loaded.warnings.push_back(fmt::format("unknown variable {} is ignored", name));
    } else {
      layer.set(*found, name, value);
    }
  }
}

void read_flags(const NamedValues& flags, LoadedConfig& loaded) {
  Layer layer(loaded, "flag");
  for (const auto& [name, value] : flags) {
    if (const Setting* setting = find_setting(name)) {
      layer.set(*setting, "--" + name, value);
    } else {
      loaded.problems.push_back(fmt::format("--{}: there is no such setting", name));
    }
  }
}

// Who reaches the server from elsewhere needs a key, unless the operator says otherwise.
void check_reach(LoadedConfig& loaded) {
  const Config& config = loaded.config;
  const auto is_far = [](const std::string& listen) {
    const auto address = parse_address(listen);
    return address && !is_loopback(*address);
  };
  if (is_far(config.admin_listen))
    loaded.warnings.push_back(
        fmt::format("{} can be reached from other machines, and health and metrics need no key there",
                    config.admin_listen));
  if (!is_far(config.listen) || !config.api_keys_file.empty()) return;
  if (config.allow_anonymous == "on")
    loaded.warnings.push_back(fmt::format(
        "{} can be reached from other machines, and there are no API keys: whoever reaches it may use it",
        config.listen));
  else
    loaded.problems.push_back(fmt::format(
        "listen: {} can be reached from other machines, and there are no API keys: set api-keys-file, "
        "or allow-anonymous = on",
        config.listen));
}

void check_outbound(LoadedConfig& loaded) {
  const Config& config = loaded.config;
  if (const std::string fault = AllowList::fault(config.remote_allow); !fault.empty())
    loaded.problems.push_back("remote-allow: " + fault);
  if (const std::string fault = AllowList::fault(config.webhook_allow); !fault.empty())
    loaded.problems.push_back("webhook-allow: " + fault);
  if (!config.webhook_allow.empty() && config.webhook_secrets_file.empty())
    loaded.problems.push_back(
        "webhook-allow: webhook-secrets-file is needed, so that receivers can tell who calls");
  if (config.remote_request_bytes < config.remote_max_bytes)
    loaded.problems.push_back(
        "remote-max-request: is less than remote-max-bytes, so that the largest file could never come in");
}

// What no single setting can know.
void check_together(LoadedConfig& loaded) {
  const Config& config = loaded.config;
  if (config.listen.empty()) loaded.problems.push_back("listen: an address is needed");
  if (config.max_bodies_bytes < config.max_body_bytes) {
    loaded.problems.push_back(
        "max-bodies: is less than max-body, so that the largest body could never come in");
  }
  if (config.determinism == "exact" && config.device != "auto" && config.device != "software") {
    loaded.problems.push_back("determinism: exact is drawn in software; device must be auto or software");
  }
  if (config.tls_certificate.empty() != config.tls_key.empty())
    loaded.problems.push_back("tls-certificate and tls-key: one is of no use without the other");
  if (const std::string fault = Cors::fault(config.cors_origins); !fault.empty())
    loaded.problems.push_back("cors-origins: " + fault);
  check_outbound(loaded);
  check_reach(loaded);
}

}  // namespace

LoadedConfig load_config(const ConfigSources& sources) {
  LoadedConfig loaded;
  for (const Setting& setting : all_settings()) loaded.origins[std::string(setting.name)] = "default";
  if (sources.file_text) read_file_text(*sources.file_text, loaded);
  read_environment(sources.environment, loaded);
  read_flags(sources.flags, loaded);
  check_together(loaded);
  return loaded;
}

std::string print_config(const LoadedConfig& loaded) {
  std::string out;
  for (const Setting& setting : all_settings()) {
    const std::string choices = setting.choices.empty() ? "" : fmt::format(" [{}]", setting.choices);
    out += fmt::format("# {}{}\n# {}, from: {}\n{} = {}\n\n", setting.help, choices,
                       environment_name(setting), loaded.origins.find(setting.name)->second, setting.name,
                       value_text(setting, loaded.config));
  }
  return out;
}

std::optional<Address> parse_address(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port_text = text.substr(colon + 1);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  if (!bracketed && host.find(':') != std::string_view::npos) return std::nullopt;
  int port = -1;
  const auto [end, fault] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (fault != std::errc{} || end != port_text.data() + port_text.size() || port < 0 || port > 65535)
    return std::nullopt;
  return Address{std::string(host), port};
}

bool is_loopback(const Address& address) {
  return address.host == "localhost" || address.host == "::1" || address.host.starts_with("127.");
}

}  // namespace furnace
