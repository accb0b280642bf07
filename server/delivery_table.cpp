#include "server/delivery_table.hpp"

#include <algorithm>
#include <array>
#include <map>

#include <fmt/format.h>

namespace furnace {
namespace {

constexpr std::array kStatusNames = {"waiting", "pending", "delivered", "failed"};

constexpr const char* kSchema = R"(
  CREATE TABLE IF NOT EXISTS deliveries(
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, status INTEGER NOT NULL, url TEXT NOT NULL,
    origin TEXT NOT NULL, traceparent TEXT NOT NULL, body TEXT NOT NULL DEFAULT '', attempts INTEGER NOT NULL DEFAULT 0,
    due_ms INTEGER NOT NULL DEFAULT 0, next_ms INTEGER NOT NULL DEFAULT 0, outcome TEXT NOT NULL DEFAULT '');
  CREATE INDEX IF NOT EXISTS by_time ON deliveries(status, next_ms, number);
)";

using Statement = Sqlite::Statement;

}  // namespace

static_assert(int(DeliveryStatus::kWaiting) == 0 && int(DeliveryStatus::kPending) == 1);

std::string_view name_of(DeliveryStatus status) {
  return kStatusNames[std::size_t(status)];
}

DeliveryTable::DeliveryTable(Sqlite& database) : database_(database) {
  database_.run(kSchema);
}

void DeliveryTable::add(const std::string& id, const Webhook& webhook) {
  Statement(database_, "INSERT INTO deliveries(id, status, url, origin, traceparent) VALUES(?,0,?,?,?)")
      .bind(std::string_view(id))
      .bind(std::string_view(webhook.url))
      .bind(std::string_view(webhook.origin))
      .bind(std::string_view(webhook.traceparent))
      .step();
}

void DeliveryTable::make_due(const std::string& id, std::string_view body, std::int64_t now_ms) {
  Statement(database_, "UPDATE deliveries SET status=1, body=?, due_ms=?, next_ms=? WHERE id=? AND status=0")
      .bind(body)
      .bind(now_ms)
      .bind(now_ms)
      .bind(std::string_view(id))
      .step();
}

std::optional<DeliveryState> DeliveryTable::find(const std::string& id) {
  Statement row(database_, "SELECT status, attempts, next_ms, outcome FROM deliveries WHERE id=?");
  if (!row.bind(std::string_view(id)).step()) return std::nullopt;
  return DeliveryState{DeliveryStatus(row.number(0)), int(row.number(1)), row.number(2), row.text(3)};
}

std::int64_t DeliveryTable::unfinished() {
  return database_.number_of("SELECT COUNT(*) FROM deliveries WHERE status<2");
}

void DeliveryTable::forget(const std::string& id, bool all) {
  Statement(database_,
            all ? "DELETE FROM deliveries WHERE id=?" : "DELETE FROM deliveries WHERE id=? AND status<>1")
      .bind(std::string_view(id))
      .step();
}

DeliveryTable::Others DeliveryTable::others() const {
  Others others;
  std::map<std::string_view, int> uses;
  std::string ids, origins;
  const auto add = [&](std::string& list, const std::string& value) {
    list += list.empty() ? "?" : ",?";
    others.values.push_back(value);
  };
  for (const UnderWay& one : under_way_) add(ids, one.id);
  for (const UnderWay& one : under_way_)
    if (++uses[one.origin] == kMostPerOrigin) add(origins, one.origin);
  others.sql = fmt::format("id NOT IN ({}) AND origin NOT IN ({})", ids, origins);
  return others;
}

std::optional<DeliveryWork> DeliveryTable::begin(std::int64_t now_ms) {
  const Others others = this->others();
  DeliveryWork work;
  {
    Statement next(database_,
                   fmt::format("SELECT id, url, origin, traceparent, body, attempts, due_ms FROM deliveries "
                               "WHERE status=1 AND next_ms<=? AND {} ORDER BY next_ms, number LIMIT 1",
                               others.sql));
    next.bind(now_ms);
    for (const std::string& value : others.values) next.bind(std::string_view(value));
    if (!next.step()) return std::nullopt;
    work = {next.text(0),
            {next.text(1), next.text(2), next.text(3)},
            next.text(4),
            int(next.number(5)) + 1,
            next.number(6)};
  }
  Statement(database_, "UPDATE deliveries SET attempts=attempts+1 WHERE id=?")
      .bind(std::string_view(work.id))
      .step();
  under_way_.push_back({work.id, work.webhook.origin});
  return work;
}

std::optional<std::int64_t> DeliveryTable::next_ms() {
  const Others others = this->others();
  Statement next(database_,
                 fmt::format("SELECT next_ms FROM deliveries WHERE status=1 AND {} ORDER BY next_ms LIMIT 1",
                             others.sql));
  for (const std::string& value : others.values) next.bind(std::string_view(value));
  return next.step() ? std::optional(next.number(0)) : std::nullopt;
}

void DeliveryTable::end(const std::string& id) {
  std::erase_if(under_way_, [&](const UnderWay& one) { return one.id == id; });
}

void DeliveryTable::put_back(const std::string& id) {
  end(id);
  Statement(database_, "UPDATE deliveries SET attempts=attempts-1 WHERE id=?")
      .bind(std::string_view(id))
      .step();
}

void DeliveryTable::try_again(const std::string& id, std::int64_t next_ms, std::string_view outcome) {
  end(id);
  Statement(database_, "UPDATE deliveries SET next_ms=?, outcome=? WHERE id=?")
      .bind(next_ms)
      .bind(outcome)
      .bind(std::string_view(id))
      .step();
}

void DeliveryTable::finish(const std::string& id, DeliveryStatus status, std::string_view outcome) {
  end(id);
  Statement(database_, "UPDATE deliveries SET status=?, outcome=?, body='' WHERE id=?")
      .bind(std::int64_t(status))
      .bind(outcome)
      .bind(std::string_view(id))
      .step();
  // Nobody asks for it any more.
  Statement(database_, "DELETE FROM deliveries WHERE id=? AND id NOT IN (SELECT id FROM jobs)")
      .bind(std::string_view(id))
      .step();
}

}  // namespace furnace
