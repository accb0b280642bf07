#include "renderer/base/deadline.hpp"

#include "renderer/base/error.hpp"

#include <string>

namespace furnace {

void check_deadline(const Deadline& deadline, std::string_view stage) {
  if (deadline.passed()) fail_deadline(deadline, stage);
}

void fail_deadline(const Deadline& deadline, std::string_view stage) {
  const std::string reason =
      deadline.cancelled() ? "the request was cancelled" : "the time of the request is over";
  fail(ErrorCode::kDeadlineExceeded, reason + " (stage: " + std::string(stage) + ")");
}

}  // namespace furnace
