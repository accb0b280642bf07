// How much of something a client may have in a time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "renderer/base/deadline.hpp"

namespace furnace {

// What RateLimit fields tell.
struct Allowance {
  bool granted = true;
  int left = 0;
  int retry_s = 0;  // when not granted: until one is
  int reset_s = 0;  // until all of it is there again
};

// A bucket of `per_minute` tokens that fills evenly: a burst of a minute's worth, then the rate.
// Threads: one at a time. Owns: a value.
class TokenBucket {
 public:
  explicit TokenBucket(int per_minute, Clock::time_point now)
      : per_minute_(per_minute), tokens_(per_minute), at_(now) {}

  Allowance take(Clock::time_point now) {
    const double per_s = per_minute_ / 60.0;
    const double passed_s = std::max(0.0, std::chrono::duration<double>(now - at_).count());
    tokens_ = std::min(double(per_minute_), tokens_ + passed_s * per_s);
    at_ = now;
    Allowance out;
    // So near to one is one: sums of small times round.
    constexpr double kAlmostOne = 1 - 1e-9;
    out.granted = tokens_ >= kAlmostOne;
    if (out.granted) tokens_ = std::max(0.0, tokens_ - 1);
    out.left = int(tokens_);
    out.retry_s = out.granted ? 0 : int(std::ceil((1 - tokens_) / per_s));
    out.reset_s = int(std::ceil((per_minute_ - tokens_) / per_s));
    return out;
  }

 private:
  int per_minute_;
  double tokens_;
  Clock::time_point at_;
};

// `per_day` from one midnight of UTC to the next.
// Threads: one at a time. Owns: a value.
class DayQuota {
 public:
  explicit DayQuota(int per_day) : per_day_(per_day) {}

  Allowance take(std::int64_t unix_s) {
    if (unix_s / kDayS != day_) used_ = 0;
    day_ = unix_s / kDayS;
    Allowance out;
    out.granted = used_ < per_day_;
    if (out.granted) ++used_;
    out.left = std::max(0, per_day_ - used_);
    out.reset_s = int(kDayS - unix_s % kDayS);
    out.retry_s = out.granted ? 0 : out.reset_s;
    return out;
  }
  // What was granted turned out to be so many more, or fewer.
  void correct(int more) { used_ = std::max(0, used_ + more); }

 private:
  static constexpr std::int64_t kDayS = 86'400;
  int per_day_;
  std::int64_t day_ = 0;
  int used_ = 0;
};

}  // namespace furnace
