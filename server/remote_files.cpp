#include "server/remote_files.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kEntryBytes = 1024;  // what an entry costs beside its file
constexpr milliseconds kLongestWait{5000};  // for a place among the fetches
constexpr std::int64_t kStepsBack = 10;     // how far back an entity tag is looked for

// As a path of a URL: what is special in a URL is not so in a file's name.
std::string path_text(const std::string& relative) {
  std::string out;
  for (std::size_t at = 0; at <= relative.size();) {
    const std::size_t slash = std::min(relative.find('/', at), relative.size());
    out += fmt::format("{}{}", at == 0 ? "" : "/", percent_encoded(relative.substr(at, slash - at)));
    at = slash + 1;
  }
  return out;
}

OutboundUrl checked_url(const std::string& text, const AllowList& allowed) {
  const std::optional<OutboundUrl> url = parse_outbound_url(text);
  if (!url)
    fail(ErrorCode::kUnprocessable, "this is no https URL with a plain host, without user and password");
  if (!allowed.allows(*url))
    fail(ErrorCode::kUnprocessable,
         fmt::format("\"{}\" is not among the hosts that this server fetches from", url->host));
  return *url;
}

OutboundUrl sibling_url(const OutboundUrl& model, const std::string& relative) {
  const std::string folder = model.path.substr(0, model.path.rfind('/') + 1);
  const std::optional<OutboundUrl> url = resolve_outbound_url(model, path_text(relative));
  if (!url || !url->has_origin_of(model) || !url->path.starts_with(folder))
    fail(ErrorCode::kUnprocessable, "the model names a file that is not in its folder or below");
  return *url;
}

[[noreturn]] void fail_fetch(const OutboundUrl& url, const OutboundAnswer& answer, const Deadline& deadline) {
  ErrorCode code = ErrorCode::kBadGateway;
  std::string what = "gave no whole file";
  switch (answer.fault) {
    case OutboundFault::kRefused:
      code = ErrorCode::kUnprocessable;
      what = "leads to where this server may not go";
      break;
    case OutboundFault::kTimeout:
      code = ErrorCode::kDeadlineExceeded;
      what = "did not answer in time";
      break;
    case OutboundFault::kTooLarge:
      code = ErrorCode::kTooLarge;
      what = "has a larger file than is fetched";
      break;
    case OutboundFault::kCancelled:
      fail_deadline(deadline, "fetch");
    case OutboundFault::kUnreachable:
      what = "cannot be reached";
      break;
    case OutboundFault::kNone:
      what = fmt::format("answered with status {}", answer.status);
      break;
    case OutboundFault::kBadAnswer:
      break;
  }
  fail(code, fmt::format("\"{}\" {}", url.host, what), {}, answer.detail);
}

std::string result_of(const OutboundAnswer& answer) {
  return answer.fault == OutboundFault::kNone ? std::to_string(answer.status)
                                              : std::string(name_of(answer.fault));
}

}  // namespace

RemoteFiles::RemoteFiles(OutboundClient client, const RemoteConfig& config, Metrics& metrics)
    : client_(std::move(client)),
      config_(config),
      metrics_(metrics),
      places_(config.max_fetches),
      fetched_(config.cache_bytes, [](const Fetched& fetched) {
        return kEntryBytes + (fetched.file ? std::int64_t(fetched.file->size()) : 0);
      }) {}

AssetResolver::RemoteFiles RemoteFiles::of_request(const Deadline& deadline) {
  return [this, deadline, left = std::make_shared<std::int64_t>(config_.max_request_bytes)](
             const std::string& url, const std::string& relative) {
    std::optional<Blob> file = read(url, relative, deadline);
    if (file) *left -= std::int64_t(file->size());
    if (*left < 0)
      fail(ErrorCode::kTooLarge, "the files that this request has fetched are too large together");
    return file;
  };
}

std::optional<Blob> RemoteFiles::read(const std::string& text, const std::string& relative,
                                      const Deadline& deadline) {
  const OutboundUrl url = checked_url(text, client_.allowed());
  if (!relative.empty()) return fetch(sibling_url(url, relative), deadline)->file;
  const auto fetched = fetch(url, deadline);
  if (!fetched->file) fail(ErrorCode::kBadGateway, fmt::format("\"{}\" has no such file", url.host));
  return fetched->file;
}

std::shared_ptr<const RemoteFiles::Fetched> RemoteFiles::fetch(const OutboundUrl& url,
                                                               const Deadline& deadline) {
  const std::int64_t step = Clock::now().time_since_epoch() / config_.freshness;
  const auto key = [&](std::int64_t at) { return HashBuilder().add(url.text).add(at).finish(); };
  return fetched_.get_or_load(key(step), deadline, [&] {
    std::shared_ptr<const Fetched> before;
    for (std::int64_t back = 1; back <= kStepsBack && !before; ++back)
      before = fetched_.find(key(step - back));
    return ask(url, before, deadline);
  });
}

RemoteFiles::Fetched RemoteFiles::ask(const OutboundUrl& url, const std::shared_ptr<const Fetched>& before,
                                      const Deadline& deadline) {
  if (!places_.try_acquire_until(std::min(deadline.end(), Clock::now() + kLongestWait)))
    fail(ErrorCode::kOverloaded, "too many files are being fetched; try again later");
  const std::shared_ptr<void> place(nullptr, [this](void*) { places_.release(); });
  OutboundRequest request{url};
  const bool can_compare = before && before->file && !before->etag.empty();
  if (can_compare) request.headers.emplace_back("If-None-Match", before->etag);
  OutboundAnswer answer = client_.send(request, deadline);
  metrics_.remote_fetches.Add({{"result", result_of(answer)}}).Increment();
  log::info("remote.fetch", {{"host", url.host}, {"result", result_of(answer)}, {"detail", answer.detail}});
  if (answer.fault == OutboundFault::kNone) {
    if (can_compare && answer.status == 304) return *before;
    if (answer.status == 404 || answer.status == 410) return {};
    if (answer.status == 200) {
      metrics_.remote_bytes.Increment(double(answer.body.size()));
      return {Blob(std::move(answer.body)), std::move(answer.etag)};
    }
  }
  fail_fetch(url, answer, deadline);
}

}  // namespace furnace
