// The time of day for what has an age: the system's when it is first asked for, and evenly on from there. Somebody who sets the
// clock neither ends nor prolongs the life of anything; a new process believes the clock again.
#pragma once

#include <chrono>

namespace furnace {

// Threads: any.
std::chrono::system_clock::time_point even_now();

}  // namespace furnace
