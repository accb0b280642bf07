// A SocketIo as cpp-httplib reads and writes it.
#pragma once

#include <cstddef>
#include <string>

#include <httplib.h>

#include "server/socket_io.hpp"

namespace furnace {

// A head goes on without its Range field: the library would answer 416 to one that it cannot read, whatever the method and
// the unit, and both must be ignored where no ranges are given out (RFC 9110 section 14.2).
// Threads: one. Owns: the line that is being read.
class HttpStream : public httplib::Stream {
 public:
  explicit HttpStream(SocketIo& io) : io_(io) {}

  void end_head() { in_head_ = false; }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* out, size_t size) override;
  ssize_t write(const char* data, size_t size) override;
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return io_.socket(); }

 private:
  bool next_line();

  SocketIo& io_;
  bool in_head_ = true;
  bool in_fields_ = false;  // the request's line has been read
  std::string line_;
  std::size_t next_ = 0;  // first byte of line_ not yet read
};

}  // namespace furnace
