#include "server/in_flight.hpp"

#include <vector>

#include "server/socket_io.hpp"

namespace furnace {

InFlight::Entry::Entry(InFlight& owner, int socket) : owner_(owner), socket_(socket) {
  const std::lock_guard lock(owner_.mutex_);
  place_ = owner_.entries_.insert(owner_.entries_.end(), this);
}

InFlight::Entry::~Entry() {
  const std::lock_guard lock(owner_.mutex_);
  owner_.entries_.erase(place_);
}

int InFlight::cancel_abandoned() {
  const std::lock_guard lock(mutex_);
  std::vector<int> sockets;
  for (const Entry* entry : entries_) sockets.push_back(entry->socket_);
  const std::vector<bool> gone = hung_up(sockets);
  int cancelled = 0;
  std::size_t i = 0;
  for (Entry* entry : entries_) {
    if (gone[i++] && entry->stop_.request_stop()) ++cancelled;
  }
  return cancelled;
}

void InFlight::cancel_all() {
  const std::lock_guard lock(mutex_);
  for (Entry* entry : entries_) entry->stop_.request_stop();
}

}  // namespace furnace
