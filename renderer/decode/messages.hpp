// What the two processes say: datagrams of a socket pair, files and pixels beside them as descriptors of memory.
#pragma once

#include <cstdint>
#include <string>

#include "renderer/base/error.hpp"
#include "renderer/decode/jobs.hpp"

namespace furnace::decode {

inline constexpr std::uint32_t kMagic =
    0x44'6e'72'46;  // "FrnD"; both ends are one program, so there are no versions
inline constexpr std::size_t kMostMessageBytes = 32 << 10;
inline constexpr std::size_t kMostTextBytes = 8 << 10;

// Of a child that is ready.
struct Hello {
  std::uint32_t magic = kMagic;
  std::string problem;  // why its sandbox is not whole; empty: it is
};

// To a child, with the arguments behind it, the file and the block for arrays as descriptors.
struct Request {
  std::uint32_t magic = kMagic;
  JobKind kind{};
  std::uint64_t serial = 0;
  std::uint64_t file_bytes = 0, block_bytes = 0;
};

// From a child, with the result behind it if there is no error.
struct Reply {
  std::uint32_t magic = kMagic;
  std::uint64_t serial = 0;
  bool failed = false;
  Error error;
};

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Hello>& hello) {
  wire.number(hello.magic);
  wire.text(hello.problem, kMostTextBytes);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Request>& request) {
  wire.number(request.magic);
  wire.choice(request.kind, JobKind{0xff});
  wire.number(request.serial);
  wire.number(request.file_bytes);
  wire.number(request.block_bytes);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Error>& error) {
  wire.choice(error.code, ErrorCode::kStorage);
  wire.text(error.message, kMostTextBytes);
  wire.text(error.pointer, kMostTextBytes);
  wire.text(error.detail, kMostTextBytes);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Reply>& reply) {
  wire.number(reply.magic);
  wire.number(reply.serial);
  std::uint8_t failed = reply.failed ? 1 : 0;
  wire.number(failed);
  if constexpr (Wire::kReads) reply.failed = failed != 0;
  if (reply.failed) fields(wire, reply.error);
}

}  // namespace furnace::decode
