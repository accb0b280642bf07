// A cache bounded by bytes, least recently used out first; equal loads that overlap in time are one load.
#pragma once

#include "renderer/base/check.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/base/error.hpp"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>
#include <unordered_map>
#include <utility>

namespace furnace {

enum class CacheOutcome {
  kHit,     // it was there
  kJoined,  // another caller was loading it; waited for that
  kLoaded,  // loaded by this call
};

struct CacheStats {
  std::int64_t hits = 0;
  std::int64_t joins = 0;
  std::int64_t loads = 0;  // begun, whether they succeeded or not
  std::int64_t evictions = 0;
  std::int64_t waiting = 0;  // callers that wait for a load just now
  std::int64_t entries = 0;
  std::int64_t bytes = 0;
};

// Threads: any. Owns: a share of each value it keeps; a value in use outlives its eviction.
template <class Value, class Key = ContentHash>
class BudgetCache {
 public:
  using Pointer = std::shared_ptr<const Value>;
  using SizeOf = std::function<std::int64_t(const Value&)>;

  // A value larger than the whole budget is handed out but not kept; a budget of 0 keeps nothing and still
  // joins loads.
  BudgetCache(std::int64_t budget_bytes, SizeOf size_of)
      : budget_(budget_bytes), size_of_(std::move(size_of)) {}

  Pointer find(const Key& key);

  // The value of `key`; when it is missing, loader() (a Value or a pointer to one) runs on this thread,
  // outside of the lock, and others who want the same wait for it as long as their deadlines allow. Its
  // failure is theirs too and is not remembered; only kDeadlineExceeded is the loader's own affair: then the
  // next of those who wait loads. A loader must not wait for a thread that could itself be waiting in this
  // cache.
  template <class Loader>
  Pointer get_or_load(const Key& key, const Deadline& deadline, Loader&& loader,
                      CacheOutcome* outcome = nullptr);

  void clear();
  CacheStats stats() const;

 private:
  struct Entry {
    Key key;
    Pointer value;
    std::int64_t bytes;
  };

  // One load and those who wait for it. All members belong to mutex_.
  struct Flight {
    bool led = true;  // somebody's loader is running
    int waiting = 0;
    Pointer value;
    std::optional<Error> error;  // a copy for each who waits: an Error changes as it gathers breadcrumbs
    std::exception_ptr foreign_failure;
    std::condition_variable_any changed;

    bool landed() const { return value || error || foreign_failure; }
  };
  using FlightPointer = std::shared_ptr<Flight>;

  Pointer touch(const Key& key);
  Pointer wait_for(Flight& flight, const Deadline& deadline, std::unique_lock<std::mutex>& lock);
  template <class Loader>
  Pointer lead(const Key& key, Flight& flight, Loader&& loader, std::unique_lock<std::mutex>& lock);
  template <class Loader>
  Pointer load(Loader& loader);
  void keep(const Key& key, const Pointer& value, std::int64_t bytes);

  const std::int64_t budget_;
  const SizeOf size_of_;
  mutable std::mutex mutex_;
  std::list<Entry> recent_;  // most recently used first
  std::unordered_map<Key, typename std::list<Entry>::iterator> entries_;
  std::unordered_map<Key, FlightPointer> flights_;
  CacheStats stats_;
};

template <class Value, class Key>
auto BudgetCache<Value, Key>::touch(const Key& key) -> Pointer {
  const auto found = entries_.find(key);
  if (found == entries_.end()) return nullptr;
  recent_.splice(recent_.begin(), recent_, found->second);
  ++stats_.hits;
  return found->second->value;
}

template <class Value, class Key>
auto BudgetCache<Value, Key>::find(const Key& key) -> Pointer {
  const std::lock_guard lock(mutex_);
  return touch(key);
}

template <class Value, class Key>
template <class Loader>
auto BudgetCache<Value, Key>::get_or_load(const Key& key, const Deadline& deadline, Loader&& loader,
                                          CacheOutcome* outcome) -> Pointer {
  const auto report = [&](CacheOutcome value) {
    if (outcome) *outcome = value;
  };
  std::unique_lock lock(mutex_);
  if (Pointer value = touch(key)) {
    report(CacheOutcome::kHit);
    return value;
  }
  const auto [place, is_new] = flights_.try_emplace(key);
  if (is_new) place->second = std::make_shared<Flight>();
  const FlightPointer flight = place->second;
  if (!is_new) {
    if (Pointer value = wait_for(*flight, deadline, lock)) {
      report(CacheOutcome::kJoined);
      return value;
    }
  }
  report(CacheOutcome::kLoaded);
  return lead(key, *flight, std::forward<Loader>(loader), lock);
}

// Null when the caller has to load: the flight is then led by it.
template <class Value, class Key>
auto BudgetCache<Value, Key>::wait_for(Flight& flight, const Deadline& deadline,
                                       std::unique_lock<std::mutex>& lock) -> Pointer {
  ++flight.waiting;
  ++stats_.waiting;
  const bool changed = flight.changed.wait_until(lock, deadline.cancel_token(), deadline.end(),
                                                 [&] { return flight.landed() || !flight.led; });
  --flight.waiting;
  --stats_.waiting;
  if (!changed) {
    lock.unlock();
    fail_deadline(deadline, "waiting for the same work of another request");
  }
  if (flight.landed()) ++stats_.joins;
  if (flight.value) return flight.value;
  if (flight.error) throw Error(*flight.error);
  if (flight.foreign_failure) std::rethrow_exception(flight.foreign_failure);
  flight.led = true;
  return nullptr;
}

template <class Value, class Key>
template <class Loader>
auto BudgetCache<Value, Key>::lead(const Key& key, Flight& flight, Loader&& loader,
                                   std::unique_lock<std::mutex>& lock) -> Pointer {
  ++stats_.loads;
  lock.unlock();
  Pointer value;
  std::int64_t bytes = 0;
  std::optional<Error> error;
  std::exception_ptr foreign_failure;
  try {
    value = load(loader);
    bytes = size_of_(*value);
  } catch (const Error& caught) {
    error = caught;
  } catch (...) {
    foreign_failure = std::current_exception();
  }

  lock.lock();
  if (value) keep(key, value, bytes);
  flight.led = false;
  flight.value = value;
  if (error && error->code != ErrorCode::kDeadlineExceeded) flight.error = error;
  flight.foreign_failure = foreign_failure;
  if (flight.landed() || flight.waiting == 0) flights_.erase(key);
  flight.changed.notify_all();
  lock.unlock();

  if (error) throw std::move(*error);
  if (foreign_failure) std::rethrow_exception(std::move(foreign_failure));
  return value;
}

template <class Value, class Key>
template <class Loader>
auto BudgetCache<Value, Key>::load(Loader& loader) -> Pointer {
  if constexpr (std::is_convertible_v<std::invoke_result_t<Loader&>, Pointer>) {
    Pointer value = loader();
    FURNACE_CHECK(value, "a loader gives a value or throws");
    return value;
  } else {
    return std::make_shared<const Value>(loader());
  }
}

template <class Value, class Key>
void BudgetCache<Value, Key>::keep(const Key& key, const Pointer& value, std::int64_t bytes) {
  if (bytes > budget_) return;
  recent_.push_front({key, value, bytes});
  entries_.emplace(key, recent_.begin());
  stats_.bytes += bytes;
  while (stats_.bytes > budget_) {
    const Entry& oldest = recent_.back();
    stats_.bytes -= oldest.bytes;
    ++stats_.evictions;
    entries_.erase(oldest.key);
    recent_.pop_back();
  }
}

template <class Value, class Key>
void BudgetCache<Value, Key>::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  recent_.clear();
  stats_.bytes = 0;
}

template <class Value, class Key>
CacheStats BudgetCache<Value, Key>::stats() const {
  const std::lock_guard lock(mutex_);
  CacheStats stats = stats_;
  stats.entries = static_cast<std::int64_t>(recent_.size());
  return stats;
}

}  // namespace furnace
