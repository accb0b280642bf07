#include "server/socket_io.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <poll.h>
#include <sys/socket.h>

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kBufferBytes = 16 << 10;
constexpr milliseconds kSlice{50};  // how often a wait looks up
constexpr milliseconds kHurried{
    1000};  // time for headers, and grace of a body, while others wait for a thread
constexpr std::int64_t kMaxLingerBytes = 256ll << 20;
constexpr std::string_view kSignOfLife = "HTTP/1.1 102 Processing\r\n\r\n";  // RFC 2518 section 10.1
constexpr milliseconds kSignPeriod{1000};

using Step = TlsSession::Step;

// What a call on a socket that does not wait came to.
TlsSession::Progress progress_of(ssize_t count, Step awaited) {
  if (count > 0) return {Step::kMoved, static_cast<std::size_t>(count)};
  const bool must_wait = count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
  return {must_wait ? awaited : Step::kEnded, 0};
}

short event_of(Step step) {
  return step == Step::kWantsOutput ? POLLOUT : POLLIN;
}

// True when the socket is ready (or broken: the next call on it tells).
bool wait_ready(int socket, short events, milliseconds patience) {
  pollfd entry{socket, events, 0};
  return ::poll(&entry, 1, static_cast<int>(std::max<std::int64_t>(0, patience.count()))) > 0;
}

}  // namespace

Greeting SocketIo::handshake(const std::function<bool()>& give_up) {
  if (!tls_) return Greeting::kReady;
  const auto end = Clock::now() + limits_.header_timeout;
  do {
    const Step step = tls_->handshake().step;
    if (step == Step::kMoved) return Greeting::kReady;
    if (step == Step::kEnded) {
      if (!tls_->met_plain_http()) return Greeting::kGone;
      tls_.reset();
      return Greeting::kPlainHttp;
    }
    wait_ready(socket_, event_of(step), kSlice);
  } while (Clock::now() < end && !give_up());
  return Greeting::kGone;
}

bool SocketIo::wait_for_request(milliseconds patience, const std::function<bool()>& give_up) {
  if (next_ < buffer_.size() || (tls_ && tls_->has_unread())) return true;
  const auto end = Clock::now() + patience;
  do {
    if (wait_ready(socket_, POLLIN, std::min(kSlice, patience))) return true;
  } while (Clock::now() < end && !give_up());
  return false;
}

void SocketIo::begin_head(std::function<bool()> hurry) {
  in_head_ = true;
  hurry_ = std::move(hurry);
  begin_ = Clock::now();
  received_bytes_ = 0;
  max_bytes_ = limits_.max_head_bytes;
  fault_ = ReadFault::kNone;
}

void SocketIo::begin_body(std::int64_t max_bytes) {
  in_head_ = false;
  begin_ = Clock::now();
  received_bytes_ = 0;
  max_bytes_ = max_bytes;
}

ssize_t SocketIo::read(char* out, std::size_t size) {
  if (received_bytes_ >= max_bytes_) {
    fault_ = ReadFault::kTooMuch;
    return -1;
  }
  if (next_ == buffer_.size() && !fill()) return -1;
  const std::size_t count =
      std::min({size, buffer_.size() - next_, static_cast<std::size_t>(max_bytes_ - received_bytes_)});
  std::copy_n(buffer_.data() + next_, count, out);
  next_ += count;
  received_bytes_ += static_cast<std::int64_t>(count);
  return static_cast<ssize_t>(count);
}

TlsSession::Progress SocketIo::receive(char* out, std::size_t size) {
  return tls_ ? tls_->read(out, size)
              : progress_of(::recv(socket_, out, size, MSG_DONTWAIT), Step::kWantsInput);
}

TlsSession::Progress SocketIo::send(const char* data, std::size_t size) {
  return tls_ ? tls_->write(data, size)
              : progress_of(::send(socket_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL), Step::kWantsOutput);
}

bool SocketIo::fill() {
  buffer_.resize(kBufferBytes);
  next_ = kBufferBytes;
  const auto waiting_since = Clock::now();
  for (;;) {
    const auto [step, got] = receive(buffer_.data(), buffer_.size());
    if (step == Step::kMoved) {
      buffer_.resize(got);
      next_ = 0;
      return true;
    }
    if (step == Step::kEnded) {
      fault_ = ReadFault::kClosed;
      return false;
    }
    if (out_of_time() || Clock::now() - waiting_since > limits_.io_timeout) {
      fault_ = ReadFault::kTimeout;
      return false;
    }
    wait_ready(socket_, event_of(step), kSlice);
  }
}

bool SocketIo::out_of_time() const {
  if (!in_head_) return is_too_slow(begin_, received_bytes_);
  const auto now = Clock::now();
  return now > begin_ + limits_.header_timeout || (now > begin_ + kHurried && hurry_());
}

// When a transfer that has come to `bytes` is too slow to be waited for.
bool SocketIo::is_too_slow(Clock::time_point begin, std::int64_t bytes) const {
  const auto past_due = Clock::now() - begin - milliseconds(bytes * 1000 / limits_.min_bytes_per_s);
  return past_due > limits_.io_timeout || (past_due > kHurried && hurry_ && hurry_());
}

bool SocketIo::write(const char* data, std::size_t size) {
  const auto begin = Clock::now();
  auto last_progress = begin;
  std::size_t sent = 0;
  while (sent < size) {
    const auto [step, count] = send(data + sent, size - sent);
    const auto now = Clock::now();
    if (step == Step::kMoved) {
      sent += count;
      last_progress = now;
      continue;
    }
    if (step == Step::kEnded) return false;
    if (now - last_progress > limits_.io_timeout || is_too_slow(begin, static_cast<std::int64_t>(sent)))
      return false;
    wait_ready(socket_, event_of(step), kSlice);
  }
  return true;
}

void SocketIo::linger(milliseconds patience) {
  if (tls_) tls_->end();
  ::shutdown(socket_, SHUT_WR);
  const auto end = Clock::now() + patience;
  std::array<char, kBufferBytes> sink;
  std::int64_t swallowed = 0;
  do {
    const ssize_t got = ::recv(socket_, sink.data(), sink.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) return;
    if (got > 0) swallowed += got;
    if (got < 0) wait_ready(socket_, POLLIN, std::min(kSlice, patience));
  } while (Clock::now() < end && swallowed < kMaxLingerBytes);
}

bool SocketIo::client_listens(bool takes_interim) {
  pollfd entry{socket_, POLLRDHUP, 0};
  if (::poll(&entry, 1, 0) <= 0) return true;
  if ((entry.revents & (POLLERR | POLLHUP)) != 0 || !takes_interim) return false;
  const auto now = Clock::now();
  if (now < next_sign_) return true;
  next_sign_ = now + kSignPeriod;
  // The machine of a client that has left answers with a reset, which the next look sees.
  return send(kSignOfLife.data(), kSignOfLife.size()).bytes == kSignOfLife.size();
}

}  // namespace furnace
