// What a process gives up before it reads its first foreign byte.
#pragma once

#include <cstdint>
#include <string>

namespace furnace::decode {

struct SandboxLimits {
  std::int64_t memory_bytes = 2048ll << 20;  // of its own; shared memory is bounded by who gives it
};

// Of this process, for good: no new privileges, no dump, no further process, no file, an end when its parent's thread ends;
// then system calls only to use memory and `socket`: any other kills it. Who starts it has left it no other descriptor.
// Returns what did not work, empty if all did. Threads: the only one.
std::string enter_sandbox(int socket, const SandboxLimits& limits);

}  // namespace furnace::decode
