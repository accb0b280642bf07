// Requests being answered, so that they can be cancelled.
#pragma once

#include <list>
#include <mutex>
#include <stop_token>

namespace furnace {

// Threads: any. Owns: the stop sources of the requests' Deadlines.
class InFlight {
 public:
  // One request; removes itself. `socket` stays open as long.
  class Entry {
   public:
    Entry(InFlight& owner, int socket);
    ~Entry();
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;
    std::stop_token token() const { return stop_.get_token(); }

   private:
    friend class InFlight;
    InFlight& owner_;
    int socket_;
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
