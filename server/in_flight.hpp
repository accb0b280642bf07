// Requests being answered, so that they can be cancelled.
#pragma once

#include <list>
#include <mutex>
#include <stop_token>

namespace furnace {

class SocketIo;

// Threads: any. Owns: the stop sources of the requests' Deadlines.
class InFlight {
 public:
  // One request; removes itself. Nobody else uses `io` as long; `takes_interim` as SocketIo::client_listens.
  class Entry {
   public:
    Entry(InFlight& owner, SocketIo& io, bool takes_interim);
    ~Entry();
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;
    std::stop_token token() const { return stop_.get_token(); }

   private:
    friend class InFlight;
    InFlight& owner_;
    SocketIo& io_;
    const bool takes_interim_;
    std::stop_source stop_;
    std::list<Entry*>::iterator place_;
  };

  // Cancels those whose client has gone; returns how many are newly so.
  int cancel_abandoned();
  void cancel_all();

 private:
  std::mutex mutex_;
  std::list<Entry*> entries_;
};

}  // namespace furnace
