#include "server/even_time.hpp"

#include <ctime>

namespace furnace {
namespace {

// Unlike the steady clock it counts the sleep of the machine.
std::chrono::nanoseconds since_boot() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace

std::chrono::system_clock::time_point even_now() {
  static const std::chrono::system_clock::time_point boot = std::chrono::system_clock::now() - since_boot();
  return boot + since_boot();
}

}  // namespace furnace
