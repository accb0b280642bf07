#include "server/job_store.hpp"

#include <array>
#include <random>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/job_document.hpp"
#include "server/sqlite.hpp"

namespace furnace {

namespace {

constexpr int kSchemaVersion = 3;  // 2 knows deliveries, 3 clients; each makes of those before its own
constexpr std::array kStatusNames = {"queued", "running", "succeeded", "failed", "cancelled"};

// A file of a later version is not touched.
constexpr const char* kSchema = R"(
  CREATE TABLE IF NOT EXISTS jobs(
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, status INTEGER NOT NULL,
    priority INTEGER NOT NULL, created_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL DEFAULT 0,
    finished_ms INTEGER NOT NULL DEFAULT 0, attempts INTEGER NOT NULL DEFAULT 0, problem TEXT NOT NULL DEFAULT '',
    idempotency_key TEXT UNIQUE, request_hash TEXT NOT NULL, bytes INTEGER NOT NULL, client TEXT NOT NULL DEFAULT '');
  CREATE INDEX IF NOT EXISTS by_turn ON jobs(status, priority DESC, number);
  CREATE TABLE IF NOT EXISTS requests(id TEXT PRIMARY KEY, target TEXT NOT NULL, content_type TEXT NOT NULL, accept TEXT NOT NULL, body BLOB NOT NULL);
  CREATE TABLE IF NOT EXISTS results(id TEXT PRIMARY KEY, file BLOB NOT NULL);
)";

// Not a secret that opens anything by itself, but not to be guessed either. No picture depends on it.
std::string new_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", random());
  return id;
}

std::string hash_of(const JobRequest& request) {
  return HashBuilder()
      .add(request.target)
      .add(request.content_type)
      .add(request.accept)
      .add(request.body)
      .add(request.webhook ? request.webhook->url : "")
      .finish()
      .hex();
}

// What two clients choose is not the same; neither part has a line's end.
std::optional<std::string> key_of(const JobRequest& request) {
  if (!request.idempotency_key || request.client.empty()) return request.idempotency_key;
  return fmt::format("{}\n{}", request.client, *request.idempotency_key);
}

}  // namespace

std::string_view name_of(JobStatus status) {
  return kStatusNames[std::size_t(status)];
}

// Threads: one at a time. Owns: the connection.
struct JobStore::Database : Sqlite {
  explicit Database(const std::string& name) : Sqlite(name) {
    const std::int64_t found = number_of("PRAGMA user_version");
    if (found > kSchemaVersion)
      furnace::fail(ErrorCode::kUnprocessable,
                    fmt::format("{} was written by a newer version of this program", name));
    if (found == kSchemaVersion) {  // nothing is written to a disk that may be full
      deliveries.emplace(*this);
      return;
    }
    run(kSchema);
    if (found == 1 || found == 2) run("ALTER TABLE jobs ADD COLUMN client TEXT NOT NULL DEFAULT ''");
    deliveries.emplace(*this);
    run(fmt::format("PRAGMA user_version={}", kSchemaVersion).c_str());
  }

  std::optional<Job> find(const char* column_is, std::string_view value) {
    const std::string sql = fmt::format(
        "SELECT id, status, priority, created_ms, started_ms, finished_ms, attempts, problem, client FROM "
        "jobs WHERE "
        "{}=?",
        column_is);
    Statement statement(*this, sql.c_str());
    if (!statement.bind(value).step()) return std::nullopt;
    Job job;
    job.id = statement.text(0);
    job.status = JobStatus(statement.number(1));
    job.priority = int(statement.number(2));
    job.created_ms = statement.number(3);
    job.started_ms = statement.number(4);
    job.finished_ms = statement.number(5);
    job.attempts = int(statement.number(6));
    job.problem = statement.text(7);
    job.client = statement.text(8);
    job.delivery = deliveries->find(job.id);
    return job;
  }

  // What is told of it is not forgotten with it, unless nobody shall hear of it any more.
  void erase(const std::string& id, bool with_delivery) {
    deliveries->forget(id, with_delivery);
    for (const char* sql :
         {"DELETE FROM requests WHERE id=?", "DELETE FROM results WHERE id=?", "DELETE FROM jobs WHERE id=?"})
      Statement(*this, sql).bind(std::string_view(id)).step();
  }

  // True when it was waiting or running. Who wants to hear of it will.
  bool finish(const std::string& id, JobStatus status, std::string_view problem, std::int64_t now_ms) {
    Statement(*this, "UPDATE jobs SET status=?, problem=?, finished_ms=?, bytes=0 WHERE id=? AND status<2")
        .bind(std::int64_t(status))
        .bind(problem)
        .bind(now_ms)
        .bind(std::string_view(id))
        .step();
    if (changes() == 0) return false;
    Statement(*this, "DELETE FROM requests WHERE id=?")
        .bind(std::string_view(id))
        .step();  // not needed any more
    if (deliveries->find(id)) deliveries->make_due(id, webhook_body(*find("id", id)), now_ms);
    return true;
  }

  bool is_running(const std::string& id) {
    const std::optional<Job> job = find("id", id);
    return job && job->status == JobStatus::kRunning;
  }

  std::vector<std::string> ids_of(const char* sql, std::int64_t bound) {
    std::vector<std::string> ids;
    Statement rows(*this, sql);
    rows.bind(bound);
    while (rows.step()) ids.push_back(rows.text(0));
    return ids;
  }

  struct Progress {
    std::string id;
    RenderProgress now;
  };

  std::optional<DeliveryTable> deliveries;
  std::vector<Progress> progress;  // of what runs; not worth a write
};

using Status = std::int64_t;
static_assert(Status(JobStatus::kRunning) == 1 && Status(JobStatus::kQueued) == 0);

JobStore::JobStore(const std::filesystem::path& folder, const JobLimits& limits) : limits_(limits) {
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  const bool is_kept = !folder.empty() && ::access(folder.c_str(), W_OK | X_OK) == 0;
  if (!is_kept) {
    if (!folder.empty())
      log::error("jobs.not_kept", {{"path", folder.string()}, {"reason", "the folder cannot be written to"}});
    database_ = std::make_unique<Database>(":memory:");
    return;
  }
  file_ = folder / "jobs.sqlite";
  try {
    const std::lock_guard lock(mutex_);
    database();
  } catch (const Error& error) {
    if (error.code != ErrorCode::kStorage) throw;
    log::error("jobs.not_opened", {{"path", file_.string()}, {"reason", error.detail}});
  }
}

// A disk that was full when the process began may have room by now.
JobStore::Database& JobStore::database() {
  if (database_) return *database_;
  auto opened = std::make_unique<Database>(file_.string());
  Sqlite::Transaction whole(*opened);
  for (const std::string& id :
       opened->ids_of("SELECT id FROM jobs WHERE status=1 AND attempts>=?", limits_.max_attempts))
    opened->finish(id, JobStatus::kFailed,
                   R"({"type":"about:blank","title":"Internal Server Error","status":500,)"
                   R"("detail":"The server ended several times while it drew this."})",
                   opened->find("id", id)->created_ms);
  opened->run("UPDATE jobs SET status=0, started_ms=0 WHERE status=1");
  whole.commit();
  database_ = std::move(opened);
  return *database_;
}

JobStore::~JobStore() = default;

JobStore::Created JobStore::create(const JobRequest& request, std::int64_t now_ms) {
  trim(now_ms);
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Sqlite::Transaction whole(db);
  const std::string hash = hash_of(request);
  const std::optional<std::string> own_key = key_of(request);
  if (own_key) {
    if (const auto known = db.find("idempotency_key", *own_key)) {
      Sqlite::Statement same(db, "SELECT 1 FROM jobs WHERE id=? AND request_hash=?");
      if (!same.bind(std::string_view(known->id)).bind(std::string_view(hash)).step())
        furnace::fail(ErrorCode::kUnprocessable, "This Idempotency-Key came with another request before.");
      return {*known, false};
    }
  }
  if (db.number_of("SELECT COUNT(*) FROM jobs WHERE status=0") >= limits_.max_waiting)
    furnace::fail(ErrorCode::kOverloaded, "Too many jobs wait; try again later.");
  if (request.webhook && db.deliveries->unfinished() >= limits_.max_deliveries)
    furnace::fail(ErrorCode::kOverloaded, "Too many webhooks wait; try again later.");
  const auto bytes = std::int64_t(request.body.size());
  if (db.number_of("SELECT COALESCE(SUM(bytes), 0) FROM jobs") + bytes > limits_.max_bytes)
    furnace::fail(ErrorCode::kOverloaded,
                  "The jobs that are kept leave no room for this one; try again later.");

  const std::string id = new_id();
  Sqlite::Statement(
      db,
      "INSERT INTO jobs(id, status, priority, created_ms, idempotency_key, request_hash, bytes, client) "
      "VALUES(?,0,?,?,?,?,?,?)")
      .bind(std::string_view(id))
      .bind(std::int64_t(request.priority))
      .bind(now_ms)
      .bind(own_key)
      .bind(std::string_view(hash))
      .bind(bytes)
      .bind(std::string_view(request.client))
      .step();
  Sqlite::Statement(db, "INSERT INTO requests VALUES(?,?,?,?,?)")
      .bind(std::string_view(id))
      .bind(std::string_view(request.target))
      .bind(std::string_view(request.content_type))
      .bind(std::string_view(request.accept))
      .bind_blob(request.body)
      .step();
  if (request.webhook) db.deliveries->add(id, *request.webhook);
  Job job = *db.find("id", id);
  whole.commit();
  return {std::move(job), true};
}

std::optional<JobWork> JobStore::begin(std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Sqlite::Transaction whole(db);
  JobWork work;
  {
    Sqlite::Statement next(
        db,
        "SELECT jobs.id, target, content_type, accept, body, priority FROM jobs JOIN requests USING(id) "
        "WHERE status=0 ORDER BY priority DESC, number LIMIT 1");
    if (!next.step()) return std::nullopt;
    work = {next.text(0),
            {next.text(1), next.text(2), next.text(3), next.text(4), int(next.number(5)), {}, {}, {}}};
  }
  Sqlite::Statement(db, "UPDATE jobs SET status=1, started_ms=?, attempts=attempts+1 WHERE id=?")
      .bind(now_ms)
      .bind(std::string_view(work.id))
      .step();
  whole.commit();
  db.progress.push_back({work.id, {}});
  return work;
}

void JobStore::put_back(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Sqlite::Statement(database(),
                    "UPDATE jobs SET status=0, started_ms=0, attempts=attempts-1 WHERE id=? AND status=1")
      .bind(std::string_view(id))
      .step();
  std::erase_if(database_->progress, [&](const auto& p) { return p.id == id; });
}

void JobStore::tell_progress(const std::string& id, const RenderProgress& now) {
  const std::lock_guard lock(mutex_);
  for (Database::Progress& progress : database().progress)
    if (progress.id == id) progress.now = now;
}

void JobStore::succeed(const std::string& id, std::string_view result, std::int64_t now_ms) {
  {
    const std::lock_guard lock(mutex_);
    Database& db = database();
    std::erase_if(db.progress, [&](const auto& p) { return p.id == id; });
    Sqlite::Transaction whole(db);
    if (!db.is_running(id) || !db.finish(id, JobStatus::kSucceeded, {}, now_ms)) return;
    Sqlite::Statement(db, "INSERT INTO results VALUES(?,?)")
        .bind(std::string_view(id))
        .bind_blob(result)
        .step();
    Sqlite::Statement(db, "UPDATE jobs SET bytes=? WHERE id=?")
        .bind(std::int64_t(result.size()))
        .bind(std::string_view(id))
        .step();
    whole.commit();
  }
  trim(now_ms);
}

void JobStore::fail(const std::string& id, std::string_view problem, std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  std::erase_if(db.progress, [&](const auto& p) { return p.id == id; });
  Sqlite::Transaction whole(db);
  if (db.is_running(id)) db.finish(id, JobStatus::kFailed, problem, now_ms);
  whole.commit();
}

std::optional<Job> JobStore::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  std::optional<Job> job = database().find("id", id);
  for (const Database::Progress& progress : database().progress)
    if (job && progress.id == id) job->progress = progress.now;
  return job;
}

std::optional<std::string> JobStore::result(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Sqlite::Statement statement(database(), "SELECT file FROM results WHERE id=?");
  if (!statement.bind(std::string_view(id)).step()) return std::nullopt;
  return statement.text(0);
}

bool JobStore::remove(const std::string& id, std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Sqlite::Transaction whole(db);
  const std::optional<Job> job = db.find("id", id);
  if (!job) return false;
  if (is_finished(job->status)) {
    db.erase(id, true);
  } else {
    db.finish(id, JobStatus::kCancelled, {}, now_ms);
  }
  whole.commit();
  return true;
}

std::optional<DeliveryWork> JobStore::begin_delivery(std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  if (!database_) return std::nullopt;
  return database_->deliveries->begin(now_ms);
}

std::optional<std::int64_t> JobStore::next_delivery_ms() {
  const std::lock_guard lock(mutex_);
  if (!database_) return std::nullopt;
  return database_->deliveries->next_ms();
}

void JobStore::put_back_delivery(const std::string& id) {
  const std::lock_guard lock(mutex_);
  database_->deliveries->put_back(id);
}

void JobStore::try_delivery_again(const std::string& id, std::int64_t next_ms, std::string_view outcome) {
  const std::lock_guard lock(mutex_);
  database_->deliveries->try_again(id, next_ms, outcome);
}

void JobStore::finish_delivery(const std::string& id, DeliveryStatus status, std::string_view outcome) {
  const std::lock_guard lock(mutex_);
  database_->deliveries->finish(id, status, outcome);
}

std::int64_t JobStore::unfinished_deliveries() {
  const std::lock_guard lock(mutex_);
  return database_ ? database_->deliveries->unfinished() : 0;
}

int JobStore::waiting() {
  const std::lock_guard lock(mutex_);
  if (!database_) return 0;
  return int(database_->number_of("SELECT COUNT(*) FROM jobs WHERE status=0"));
}

void JobStore::trim(std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Sqlite::Transaction whole(db);
  const auto erase_each = [&](const char* sql, std::int64_t bound) {
    const std::vector<std::string> ids = db.ids_of(sql, bound);
    for (const std::string& id : ids) db.erase(id, false);
    return ids.size();
  };
  erase_each("SELECT id FROM jobs WHERE status>1 AND finished_ms<?", now_ms - limits_.keep_ms);
  while (db.number_of("SELECT COALESCE(SUM(bytes), 0) FROM jobs") > limits_.max_bytes &&
         erase_each("SELECT id FROM jobs WHERE status>1 ORDER BY finished_ms, number LIMIT ?", 1) > 0) {
  }
  whole.commit();
}

}  // namespace furnace
