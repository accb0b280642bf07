// Reports of the last renders, by the entity tags of their pictures.
#pragma once

#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace furnace {

// Threads: any. Owns: the reports.
class ReportStore {
 public:
  // 0 keeps none. What was put or found least recently goes first.
  explicit ReportStore(std::int64_t budget_bytes) : budget_(budget_bytes) {}

  // Takes the place of an older report of that name; one that is larger than the budget is not kept.
  void put(const std::string& name, std::string report);
  std::optional<std::string> find(const std::string& name);

 private:
  struct Entry {
    std::string name;
    std::string report;
    std::int64_t bytes() const;
  };
  using Place = std::list<Entry>::iterator;

  void erase(Place place);

  const std::int64_t budget_;
  std::mutex mutex_;                                     // of all below
  std::list<Entry> recent_;                              // most recently used first
  std::unordered_map<std::string_view, Place> entries_;  // keys stand in recent_
  std::int64_t bytes_ = 0;
};

}  // namespace furnace
