// A body as it comes in: into the request's memory, or into the sink that its route has opened; within its bounds.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "server/framing.hpp"
#include "server/http_types.hpp"

namespace furnace {

// Threads: one, but for the sum. Owns: its share of the sum of all bodies in memory.
class BodyReceiver {
 public:
  // `all_bytes`, which outlives this, is the sum over all requests; it may be `max_all_bytes`.
  BodyReceiver(std::atomic<std::int64_t>& all_bytes, std::int64_t max_all_bytes)
      : all_bytes_(all_bytes), max_all_bytes_(max_all_bytes) {}
  ~BodyReceiver() { give_room_back(); }
  BodyReceiver(const BodyReceiver&) = delete;
  BodyReceiver& operator=(const BodyReceiver&) = delete;

  // What the body may have; before the first piece.
  void allow(std::int64_t max_bytes) { max_bytes_ = max_bytes; }
  // False when it is refused, and why in refusal(); nothing more may come then.
  bool take(std::string_view piece, Request& request);
  const Refusal& refusal() const { return refusal_; }  // status 0: none
  void give_room_back();

 private:
  bool keep(std::string_view piece, Request& request);
  bool pass_on(std::string_view piece, BodySink& sink);

  std::atomic<std::int64_t>& all_bytes_;
  const std::int64_t max_all_bytes_;
  std::int64_t max_bytes_ = 0;
  std::int64_t received_bytes_ = 0;
  std::int64_t held_bytes_ = 0;  // in memory
  Refusal refusal_;
};

}  // namespace furnace
