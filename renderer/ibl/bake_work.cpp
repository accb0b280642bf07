#include "renderer/ibl/bake_work.hpp"

#include <algorithm>

namespace furnace {

void BakeWork::begin(std::string_view stage, double share) {
  stage_ = stage;
  before_ += share_;
  share_ = share;
  check_deadline(deadline_, stage_);
  report(0);
}

void BakeWork::finish() {
  before_ = 1;
  share_ = 0;
  report(0);
}

void BakeWork::parallel_for(std::size_t count, double cost_us, const std::function<void(std::size_t)>& body) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
  pool_.parallel_for(count, cost_us, [&](std::size_t i) {
    check_deadline(deadline_, stage_);
    body(i);
    const std::size_t so_far = done.fetch_add(1, std::memory_order_relaxed) + 1;
    if (std::this_thread::get_id() == caller) report(double(so_far) / double(count));
  });
}

void BakeWork::report(double of_stage) {
  const double fraction = std::min(1.0, before_ + share_ * of_stage);
  if (!report_ || fraction <= reported_) return;
  reported_ = fraction;
  report_(fraction);
}

}  // namespace furnace
