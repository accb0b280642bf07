// Deliveries of webhooks, as a table of the jobs' database: what is to be told to whom, and how far that is.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/sqlite.hpp"

namespace furnace {

// Where the end of a job is told.
struct Webhook {
  std::string url;          // allowed when it was asked for
  std::string origin;       // of the URL: what is slow or gone is so as a whole
  std::string traceparent;  // the trace and our span of the request that made the job
};

enum class DeliveryStatus { kWaiting, kPending, kDelivered, kFailed };  // kWaiting: for the job's end
std::string_view name_of(DeliveryStatus status);                        // "waiting", ...

struct DeliveryState {
  DeliveryStatus status = DeliveryStatus::kWaiting;
  int attempts = 0;          // begun
  std::int64_t next_ms = 0;  // since the epoch: when it is tried next; of those pending
  std::string last_outcome;  // "503", "timeout", ...; "" before the first attempt has ended
};

// What a sender takes.
struct DeliveryWork {
  std::string id;  // the job's
  Webhook webhook;
  std::string body;
  int attempts = 0;         // begun, this one included
  std::int64_t due_ms = 0;  // since the epoch: when the job ended
};

// Threads: one at a time: the database's. The caller makes the transactions. Owns: what is under way, which a new process does
// not know: it is tried again.
class DeliveryTable {
 public:
  static constexpr int kMostPerOrigin = 2;  // under way at once

  explicit DeliveryTable(Sqlite& database);  // makes the table

  void add(const std::string& id, const Webhook& webhook);
  // The job has ended. No effect without a delivery.
  void make_due(const std::string& id, std::string_view body, std::int64_t now_ms);
  std::optional<DeliveryState> find(const std::string& id);
  std::int64_t unfinished();
  // Of a job that is forgotten; what is pending stays, unless `all`.
  void forget(const std::string& id, bool all);

  // The one that has been due for longest of an origin that has room, and is under way from now on.
  std::optional<DeliveryWork> begin(std::int64_t now_ms);
  // When begin would give one, as far as is known now.
  std::optional<std::int64_t> next_ms();
  // Each ends what begin has begun.
  void put_back(const std::string& id);  // as if it had not been tried
  void try_again(const std::string& id, std::int64_t next_ms, std::string_view outcome);
  void finish(const std::string& id, DeliveryStatus status, std::string_view outcome);

 private:
  // "id NOT IN (...) AND origin NOT IN (...)" of what is under way, and the values for it.
  struct Others {
    std::string sql;
    std::vector<std::string> values;
  };
  Others others() const;
  void end(const std::string& id);

  struct UnderWay {
    std::string id, origin;
  };
  Sqlite& database_;
  std::vector<UnderWay> under_way_;
};

}  // namespace furnace
