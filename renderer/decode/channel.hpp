// Datagrams with descriptors over a socket pair, and memory that two processes share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/descriptor.hpp"

namespace furnace::decode {

// Sealed against everything: what the other process maps stays as it is. Errors: kInternal, when there is no memory.
Descriptor sealed_copy(std::span<const std::byte> bytes);

// Zeros, of a fixed size; pages come into being as they are written to. Errors: kInternal.
Descriptor empty_block(std::size_t bytes);

struct SocketPair {
  Descriptor ours, theirs;
};
// Errors: kInternal.
SocketPair make_socket_pair();

// Whether the other end took it.
bool send_message(int socket, std::string_view bytes, std::span<const int> descriptors = {});

struct Message {
  std::string bytes;
  std::vector<Descriptor> descriptors;
};
// Waits for one. None at the end, after a fault, and when it does not fit. Descriptors beyond `most_descriptors` are closed.
std::optional<Message> receive_message(int socket, std::size_t most_descriptors = 0);

// A view of shared memory. Threads: one. Owns: the mapping.
class Mapping {
 public:
  enum class Access { kRead, kWrite };

  Mapping(int fd, std::size_t bytes, Access access);
  ~Mapping();
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  bool is_there() const { return there_; }
  std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
  bool there_ = true;
};

}  // namespace furnace::decode
