#include "server/outbound_client.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <memory>
#include <stop_token>

#include <curl/curl.h>
#include <fmt/format.h>
#include <sys/socket.h>

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr std::array<std::string_view, 7> kFaultNames = {"none",      "refused",   "unreachable", "timeout",
                                                         "cancelled", "too-large", "bad-answer"};
constexpr int kLookMs = 1000;  // a stop request and a timeout wake the wait by themselves

struct FreeEasy {
  void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
};
struct FreeMulti {
  void operator()(CURLM* multi) const { curl_multi_cleanup(multi); }
};
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Easy = std::unique_ptr<CURL, FreeEasy>;
using Multi = std::unique_ptr<CURLM, FreeMulti>;
using Headers = std::unique_ptr<curl_slist, FreeList>;

// What the callbacks of one exchange work with.
struct Exchange {
  const AllowList& allowed;
  const OutboundUrl& url;
  std::int64_t max_bytes;
  std::string body = {};
  bool was_refused = false, was_too_large = false;
};

template <class Value>
void set(const Easy& easy, CURLoption option, Value value) {
  const CURLcode outcome = curl_easy_setopt(easy.get(), option, value);
  FURNACE_CHECK(outcome == CURLE_OK, "libcurl refuses option {}: {}", int(option),
                curl_easy_strerror(outcome));
}

// libcurl asks for a socket for each address that it tries: the last moment before a connection, after every name was resolved.
curl_socket_t open_socket(void* of, curlsocktype purpose, curl_sockaddr* address) {
  auto& exchange = *static_cast<Exchange*>(of);
  const auto there = network_address_of(address->addr);
  if (purpose != CURLSOCKTYPE_IPCXN || !there || !exchange.allowed.allows_address(exchange.url, *there)) {
    exchange.was_refused = true;
    return CURL_SOCKET_BAD;
  }
  return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}

std::size_t take(const char* bytes, std::size_t, std::size_t count, void* of) {
  auto& exchange = *static_cast<Exchange*>(of);
  if (std::int64_t(exchange.body.size() + count) > exchange.max_bytes) {
    exchange.was_too_large = true;
    return 0;
  }
  exchange.body.append(bytes, count);
  return count;
}

std::string header(const Easy& easy, const char* name) {
  curl_header* found = nullptr;
  return curl_easy_header(easy.get(), name, 0, CURLH_HEADER, -1, &found) == CURLHE_OK ? found->value : "";
}

OutboundFault fault_of(CURLcode outcome, const Exchange& exchange) {
  if (outcome == CURLE_OK) return OutboundFault::kNone;
  if (exchange.was_too_large || outcome == CURLE_FILESIZE_EXCEEDED) return OutboundFault::kTooLarge;
  if (outcome == CURLE_OPERATION_TIMEDOUT) return OutboundFault::kTimeout;
  if (outcome == CURLE_COULDNT_CONNECT && exchange.was_refused) return OutboundFault::kRefused;
  const bool has_spoken = outcome == CURLE_PARTIAL_FILE || outcome == CURLE_WEIRD_SERVER_REPLY ||
                          outcome == CURLE_BAD_CONTENT_ENCODING || outcome == CURLE_UNSUPPORTED_PROTOCOL ||
                          outcome == CURLE_WRITE_ERROR;
  return has_spoken ? OutboundFault::kBadAnswer : OutboundFault::kUnreachable;
}

// As curl_easy_perform, but ends soon when the deadline's token says so. None: it did.
std::optional<CURLcode> perform(const Easy& easy, const Deadline& deadline) {
  const Multi multi(curl_multi_init());
  FURNACE_CHECK(multi != nullptr, "libcurl gives no handle");
  curl_multi_add_handle(multi.get(), easy.get());
  std::optional<CURLcode> outcome;
  {
    const std::stop_callback wake(deadline.cancel_token(), [&] { curl_multi_wakeup(multi.get()); });
    for (int running = 1; !deadline.cancelled();) {
      curl_multi_perform(multi.get(), &running);
      if (running == 0) break;
      curl_multi_poll(multi.get(), nullptr, 0, kLookMs, nullptr);
    }
  }
  int left = 0;
  while (const CURLMsg* message = curl_multi_info_read(multi.get(), &left))
    if (message->msg == CURLMSG_DONE) outcome = message->data.result;
  curl_multi_remove_handle(multi.get(), easy.get());
  return outcome;
}

void set_policy(const Easy& easy, const OutboundConfig& config, Exchange& exchange) {
  set(easy, CURLOPT_URL, exchange.url.text.c_str());
  set(easy, CURLOPT_PROTOCOLS_STR, exchange.url.scheme.c_str());
  set(easy, CURLOPT_FOLLOWLOCATION, 0L);
  set(easy, CURLOPT_PROXY, "");  // none, whatever the environment says
  set(easy, CURLOPT_NETRC, long(CURL_NETRC_IGNORED));
  set(easy, CURLOPT_HTTP_VERSION, long(CURL_HTTP_VERSION_1_1));
  set(easy, CURLOPT_SSLVERSION, long(CURL_SSLVERSION_TLSv1_2));
  set(easy, CURLOPT_NOSIGNAL, 1L);
  // A resolver that hangs ends by itself, in its own thread; nobody waits for it.
  set(easy, CURLOPT_QUICK_EXIT, 1L);
  set(easy, CURLOPT_OPENSOCKETFUNCTION, &open_socket);
  set(easy, CURLOPT_OPENSOCKETDATA, &exchange);
  set(easy, CURLOPT_WRITEFUNCTION, &take);
  set(easy, CURLOPT_WRITEDATA, &exchange);
  set(easy, CURLOPT_MAXFILESIZE_LARGE, curl_off_t(config.max_bytes));
  set(easy, CURLOPT_USERAGENT, config.user_agent.c_str());
  if (!config.ca_file.empty()) {
    set(easy, CURLOPT_CAINFO, config.ca_file.c_str());
    set(easy, CURLOPT_CAPATH, static_cast<const char*>(nullptr));
  }
}

bool is_redirect(int status) {
  return status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
}

OutboundAnswer failed(OutboundFault fault, std::string detail) {
  OutboundAnswer answer;
  answer.fault = fault;
  answer.detail = std::move(detail);
  return answer;
}

}  // namespace

std::string_view name_of(OutboundFault fault) {
  return kFaultNames[std::size_t(fault)];
}

OutboundClient::OutboundClient(AllowList allowed, OutboundConfig config)
    : allowed_(std::move(allowed)), config_(std::move(config)) {
  static const bool is_ready = [] {
    std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to connections that are gone
    return curl_global_init(CURL_GLOBAL_DEFAULT) == CURLE_OK;
  }();
  FURNACE_CHECK(is_ready, "libcurl does not start");
}

OutboundAnswer OutboundClient::send_once(const OutboundRequest& request, const OutboundUrl& url,
                                         Clock::time_point end, const Deadline& deadline,
                                         std::string& location) const {
  if (!allowed_.allows(url)) return failed(OutboundFault::kRefused, "not among the allowed: " + url.text);
  const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
  if (left.count() <= 0) return failed(OutboundFault::kTimeout, "no time is left");
  Exchange exchange{allowed_, url, config_.max_bytes};
  const Easy easy(curl_easy_init());
  FURNACE_CHECK(easy != nullptr, "libcurl gives no handle");
  set_policy(easy, config_, exchange);
  set(easy, CURLOPT_CONNECTTIMEOUT_MS, long(std::min(left, config_.connect_timeout).count()));
  set(easy, CURLOPT_TIMEOUT_MS, long(left.count()));
  Headers headers;
  const auto add = [&](const std::string& line) {
    curl_slist* longer = curl_slist_append(headers.get(), line.c_str());
    FURNACE_CHECK(longer != nullptr, "libcurl takes no header");
    static_cast<void>(headers.release());
    headers.reset(longer);
  };
  for (const auto& [name, value] : request.headers) add(fmt::format("{}: {}", name, value));
  if (request.body) {
    add("Expect:");  // no round trip before the body
    set(easy, CURLOPT_POSTFIELDSIZE_LARGE, curl_off_t(request.body->size()));
    set(easy, CURLOPT_POSTFIELDS, request.body->data());
  }
  set(easy, CURLOPT_HTTPHEADER, headers.get());

  const std::optional<CURLcode> outcome = perform(easy, deadline);
  if (!outcome) return failed(OutboundFault::kCancelled, "cancelled");
  OutboundAnswer answer;
  answer.fault = fault_of(*outcome, exchange);
  if (answer.fault != OutboundFault::kNone)
    answer.detail = fmt::format("{}: {}{}", url.host, curl_easy_strerror(*outcome),
                                exchange.was_refused ? "; an address was refused" : "");
  long status = 0;
  curl_easy_getinfo(easy.get(), CURLINFO_RESPONSE_CODE, &status);
  answer.status = int(status);
  curl_off_t retry_after_s = 0;
  curl_easy_getinfo(easy.get(), CURLINFO_RETRY_AFTER, &retry_after_s);
  answer.retry_after_s = std::max<std::int64_t>(0, retry_after_s);
  if (answer.fault != OutboundFault::kNone) return answer;
  answer.etag = header(easy, "etag");
  location = header(easy, "location");
  if (const std::string coding = header(easy, "content-encoding"); !coding.empty() && coding != "identity")
    return failed(OutboundFault::kBadAnswer, "a content coding that was not asked for: " + coding);
  answer.body = std::move(exchange.body);
  return answer;
}

OutboundAnswer OutboundClient::send(const OutboundRequest& request, const Deadline& deadline) const {
  const Clock::time_point own_end = Clock::now() + config_.timeout, end = std::min(deadline.end(), own_end);
  OutboundUrl url = request.url;
  for (int hops = 0;; ++hops) {
    std::string location;
    OutboundAnswer answer = send_once(request, url, end, deadline, location);
    if (answer.fault == OutboundFault::kTimeout && end < own_end) answer.fault = OutboundFault::kCancelled;
    const bool follows = config_.max_redirects > 0 && answer.fault == OutboundFault::kNone &&
                         is_redirect(answer.status) && !request.body;
    if (!follows) return answer;
    if (hops == config_.max_redirects) return failed(OutboundFault::kBadAnswer, "too many redirects");
    const auto next = resolve_outbound_url(url, location);
    if (location.empty() || !next) return failed(OutboundFault::kBadAnswer, "redirected to no URL");
    url = *next;
  }
}

}  // namespace furnace
