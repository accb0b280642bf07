#include "server/report_store.hpp"

#include <iterator>
#include <utility>

namespace furnace {

std::int64_t ReportStore::Entry::bytes() const {
  return std::int64_t(sizeof(Entry) + name.capacity() + report.capacity());
}

void ReportStore::put(const std::string& name, std::string report) {
  const std::lock_guard lock(mutex_);
  if (const auto known = entries_.find(name); known != entries_.end()) erase(known->second);
  Entry entry{name, std::move(report)};
  if (entry.bytes() > budget_) return;
  recent_.push_front(std::move(entry));
  entries_.emplace(recent_.front().name, recent_.begin());
  bytes_ += recent_.front().bytes();
  while (bytes_ > budget_) erase(std::prev(recent_.end()));
}

std::optional<std::string> ReportStore::find(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto known = entries_.find(name);
  if (known == entries_.end()) return std::nullopt;
  recent_.splice(recent_.begin(), recent_, known->second);
  return known->second->report;
}

void ReportStore::erase(Place place) {
  bytes_ -= place->bytes();
  entries_.erase(place->name);
  recent_.erase(place);
}

}  // namespace furnace
