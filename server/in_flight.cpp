#include "server/in_flight.hpp"

#include "server/socket_io.hpp"

namespace furnace {

InFlight::Entry::Entry(InFlight& owner, SocketIo& io, bool takes_interim)
    : owner_(owner), io_(io), takes_interim_(takes_interim) {
  const std::lock_guard lock(owner_.mutex_);
  place_ = owner_.entries_.insert(owner_.entries_.end(), this);
}

InFlight::Entry::~Entry() {
  const std::lock_guard lock(owner_.mutex_);
  owner_.entries_.erase(place_);
}

int InFlight::cancel_abandoned() {
  const std::lock_guard lock(mutex_);
  int cancelled = 0;
  for (Entry* entry : entries_)
    if (!entry->io_.client_listens(entry->takes_interim_) && entry->stop_.request_stop()) ++cancelled;
  return cancelled;
}

void InFlight::cancel_all() {
  const std::lock_guard lock(mutex_);
  for (Entry* entry : entries_) entry->stop_.request_stop();
}

}  // namespace furnace
