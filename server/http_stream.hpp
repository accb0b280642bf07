// A SocketIo as cpp-httplib reads and writes it.
#pragma once

#include <cstddef>
#include <string>

#include <httplib.h>

#include "server/socket_io.hpp"

namespace furnace {

// A head goes on without its Range field: the library would answer 416 to one that it cannot read, whatever the method and
// the unit, and would cut bodies by those that it can. Ranges are ours to serve (server/byte_range.hpp).
// Threads: one. Owns: the line that is being read.
class HttpStream : public httplib::Stream {
 public:
  explicit HttpStream(SocketIo& io) : io_(io) {}

  // What follows is no head. Gives the head's Range, empty without one; of several fields the values with commas between.
  std::string end_head();

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* out, size_t size) override;
  ssize_t write(const char* data, size_t size) override;
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return io_.socket(); }

 private:
  bool next_line();
  bool takes_range();

  SocketIo& io_;
  bool in_head_ = true;
  bool in_fields_ = false;  // the request's line has been read
  std::string range_;
  std::string line_;
  std::size_t next_ = 0;  // first byte of line_ not yet read
};

}  // namespace furnace
