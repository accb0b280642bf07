#include "server/job_store.hpp"

#include <array>
#include <random>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"

namespace furnace {

namespace {

constexpr int kSchemaVersion = 1;
constexpr std::array kStatusNames = {"queued", "running", "succeeded", "failed", "cancelled"};

// A file of another version is not touched: an older program may still need it.
constexpr const char* kSchema = R"(
  CREATE TABLE IF NOT EXISTS jobs(
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, status INTEGER NOT NULL,
    priority INTEGER NOT NULL, created_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL DEFAULT 0,
    finished_ms INTEGER NOT NULL DEFAULT 0, attempts INTEGER NOT NULL DEFAULT 0, problem TEXT NOT NULL DEFAULT '',
    idempotency_key TEXT UNIQUE, request_hash TEXT NOT NULL, bytes INTEGER NOT NULL);
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
      .finish()
      .hex();
}

}  // namespace

std::string_view name_of(JobStatus status) {
  return kStatusNames[std::size_t(status)];
}

// Threads: one at a time. Owns: the connection.
struct JobStore::Database {
  explicit Database(const std::string& name) {
    const int outcome = sqlite3_open(name.c_str(), &handle);
    owner.reset(handle);  // which is there after a failure, too
    if (outcome != SQLITE_OK) refuse("open");
    sqlite3_extended_result_codes(handle, 1);
    constexpr int kBusyMs = 5000;
    sqlite3_busy_timeout(handle, kBusyMs);
    run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;");
    Statement version(*this, "PRAGMA user_version");
    const std::int64_t found = version.step() ? version.number(0) : 0;
    version.reset();
    if (found != 0 && found != kSchemaVersion)
      furnace::fail(ErrorCode::kUnprocessable,
                    fmt::format("{} was written by another version of this program", name));
    if (found == kSchemaVersion) return;
    run(kSchema);
    run(fmt::format("PRAGMA user_version={}", kSchemaVersion).c_str());
  }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  [[noreturn]] void refuse(std::string_view doing) const {
    const bool is_foreign = handle && sqlite3_errcode(handle) == SQLITE_NOTADB;
    furnace::fail(is_foreign ? ErrorCode::kUnprocessable : ErrorCode::kStorage,
                  "The list of jobs could not be read or written.", {},
                  fmt::format("{}: {}", doing, handle ? sqlite3_errmsg(handle) : "out of memory"));
  }

  void run(const char* sql) {
    if (sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) refuse(sql);
  }

  // Threads: one. Owns: the prepared statement. Values are bound in order.
  class Statement {
   public:
    Statement(Database& database, const char* sql) : database_(database), sql_(sql) {
      if (sqlite3_prepare_v2(database.handle, sql, -1, &statement_, nullptr) != SQLITE_OK)
        database.refuse(sql);
    }
    ~Statement() { sqlite3_finalize(statement_); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(std::int64_t value) {
      sqlite3_bind_int64(statement_, ++bound_, value);
      return *this;
    }
    Statement& bind(std::string_view text) {
      sqlite3_bind_text64(statement_, ++bound_, text.data() ? text.data() : "", text.size(), SQLITE_TRANSIENT,
                          SQLITE_UTF8);
      return *this;
    }
    Statement& bind(const std::optional<std::string>& text) {
      if (text) return bind(std::string_view(*text));
      sqlite3_bind_null(statement_, ++bound_);
      return *this;
    }
    // The bytes must live until the statement has run.
    Statement& bind_blob(std::string_view bytes) {
      sqlite3_bind_blob64(statement_, ++bound_, bytes.data() ? bytes.data() : "", bytes.size(),
                          SQLITE_STATIC);
      return *this;
    }
    bool step() {
      const int outcome = sqlite3_step(statement_);
      if (outcome != SQLITE_ROW && outcome != SQLITE_DONE) database_.refuse(sql_);
      return outcome == SQLITE_ROW;
    }
    void reset() { sqlite3_reset(statement_); }
    std::int64_t number(int column) { return sqlite3_column_int64(statement_, column); }
    std::string text(int column) {
      const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
      return {bytes ? bytes : "", std::size_t(sqlite3_column_bytes(statement_, column))};
    }

   private:
    Database& database_;
    const char* sql_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
  };

  // All or nothing: rolled back unless it was committed.
  class Transaction {
   public:
    explicit Transaction(Database& database) : database_(database) { database_.run("BEGIN IMMEDIATE"); }
    ~Transaction() {
      if (!committed_) sqlite3_exec(database_.handle, "ROLLBACK", nullptr, nullptr, nullptr);
    }
    void commit() {
      database_.run("COMMIT");
      committed_ = true;
    }

   private:
    Database& database_;
    bool committed_ = false;
  };

  std::int64_t number_of(const char* sql) {
    Statement statement(*this, sql);
    return statement.step() ? statement.number(0) : 0;
  }

  std::optional<Job> find(const char* column_is, std::string_view value) {
    const std::string sql = fmt::format(
        "SELECT id, status, priority, created_ms, started_ms, finished_ms, attempts, problem FROM jobs WHERE "
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
    return job;
  }

  void erase(std::string_view id) {
    for (const char* sql :
         {"DELETE FROM requests WHERE id=?", "DELETE FROM results WHERE id=?", "DELETE FROM jobs WHERE id=?"})
      Statement(*this, sql).bind(id).step();
  }

  // True when it was running.
  bool finish(std::string_view id, JobStatus status, std::string_view problem, std::int64_t now_ms) {
    Statement(*this, "UPDATE jobs SET status=?, problem=?, finished_ms=?, bytes=0 WHERE id=? AND status=1")
        .bind(std::int64_t(status))
        .bind(problem)
        .bind(now_ms)
        .bind(id)
        .step();
    if (sqlite3_changes(handle) == 0) return false;
    Statement(*this, "DELETE FROM requests WHERE id=?").bind(id).step();  // nobody needs it any more
    return true;
  }

  struct Progress {
    std::string id;
    int done = 0, of = 0;
  };

  struct Close {
    void operator()(sqlite3* connection) const { sqlite3_close(connection); }
  };
  std::unique_ptr<sqlite3, Close> owner;
  sqlite3* handle = nullptr;
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
  Database::Transaction whole(*opened);
  Database::Statement(
      *opened, "UPDATE jobs SET status=3, finished_ms=created_ms, problem=? WHERE status=1 AND attempts>=?")
      .bind(std::string_view(R"({"type":"about:blank","title":"Internal Server Error","status":500,)"
                             R"("detail":"The server ended several times while it drew this."})"))
      .bind(std::int64_t(limits_.max_attempts))
      .step();
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
  Database::Transaction whole(db);
  const std::string hash = hash_of(request);
  if (request.idempotency_key) {
    if (const auto known = db.find("idempotency_key", *request.idempotency_key)) {
      Database::Statement same(db, "SELECT 1 FROM jobs WHERE id=? AND request_hash=?");
      if (!same.bind(std::string_view(known->id)).bind(std::string_view(hash)).step())
        furnace::fail(ErrorCode::kUnprocessable, "This Idempotency-Key came with another request before.");
      return {*known, false};
    }
  }
  if (db.number_of("SELECT COUNT(*) FROM jobs WHERE status=0") >= limits_.max_waiting)
    furnace::fail(ErrorCode::kOverloaded, "Too many jobs wait; try again later.");
  const auto bytes = std::int64_t(request.body.size());
  if (db.number_of("SELECT COALESCE(SUM(bytes), 0) FROM jobs") + bytes > limits_.max_bytes)
    furnace::fail(ErrorCode::kOverloaded,
                  "The jobs that are kept leave no room for this one; try again later.");

  const std::string id = new_id();
  Database::Statement(
      db,
      "INSERT INTO jobs(id, status, priority, created_ms, idempotency_key, request_hash, bytes) "
      "VALUES(?,0,?,?,?,?,?)")
      .bind(std::string_view(id))
      .bind(std::int64_t(request.priority))
      .bind(now_ms)
      .bind(request.idempotency_key)
      .bind(std::string_view(hash))
      .bind(bytes)
      .step();
  Database::Statement(db, "INSERT INTO requests VALUES(?,?,?,?,?)")
      .bind(std::string_view(id))
      .bind(std::string_view(request.target))
      .bind(std::string_view(request.content_type))
      .bind(std::string_view(request.accept))
      .bind_blob(request.body)
      .step();
  Job job = *db.find("id", id);
  whole.commit();
  return {std::move(job), true};
}

std::optional<JobWork> JobStore::begin(std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Database::Transaction whole(db);
  JobWork work;
  {
    Database::Statement next(
        db,
        "SELECT jobs.id, target, content_type, accept, body, priority FROM jobs JOIN requests USING(id) "
        "WHERE status=0 ORDER BY priority DESC, number LIMIT 1");
    if (!next.step()) return std::nullopt;
    work = {next.text(0), {next.text(1), next.text(2), next.text(3), next.text(4), int(next.number(5)), {}}};
  }
  Database::Statement(db, "UPDATE jobs SET status=1, started_ms=?, attempts=attempts+1 WHERE id=?")
      .bind(now_ms)
      .bind(std::string_view(work.id))
      .step();
  whole.commit();
  db.progress.push_back({work.id, 0, 0});
  return work;
}

void JobStore::put_back(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Database::Statement(database(),
                      "UPDATE jobs SET status=0, started_ms=0, attempts=attempts-1 WHERE id=? AND status=1")
      .bind(std::string_view(id))
      .step();
  std::erase_if(database_->progress, [&](const auto& p) { return p.id == id; });
}

void JobStore::tell_progress(const std::string& id, int frames_done, int frames) {
  const std::lock_guard lock(mutex_);
  for (Database::Progress& progress : database().progress)
    if (progress.id == id) progress = {id, frames_done, frames};
}

void JobStore::succeed(const std::string& id, std::string_view result, std::int64_t now_ms) {
  {
    const std::lock_guard lock(mutex_);
    Database& db = database();
    std::erase_if(db.progress, [&](const auto& p) { return p.id == id; });
    Database::Transaction whole(db);
    if (!db.finish(id, JobStatus::kSucceeded, {}, now_ms)) return;
    Database::Statement(db, "INSERT INTO results VALUES(?,?)")
        .bind(std::string_view(id))
        .bind_blob(result)
        .step();
    Database::Statement(db, "UPDATE jobs SET bytes=? WHERE id=?")
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
  Database::Transaction whole(db);
  db.finish(id, JobStatus::kFailed, problem, now_ms);
  whole.commit();
}

std::optional<Job> JobStore::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  std::optional<Job> job = database().find("id", id);
  for (const Database::Progress& progress : database().progress)
    if (job && progress.id == id) job->frames_done = progress.done, job->frames = progress.of;
  return job;
}

std::optional<std::string> JobStore::result(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Database::Statement statement(database(), "SELECT file FROM results WHERE id=?");
  if (!statement.bind(std::string_view(id)).step()) return std::nullopt;
  return statement.text(0);
}

bool JobStore::remove(const std::string& id, std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Database::Transaction whole(db);
  const std::optional<Job> job = db.find("id", id);
  if (!job) return false;
  if (is_finished(job->status)) {
    db.erase(id);
  } else {
    Database::Statement(db, "UPDATE jobs SET status=4, finished_ms=?, bytes=0 WHERE id=?")
        .bind(now_ms)
        .bind(std::string_view(id))
        .step();
    Database::Statement(db, "DELETE FROM requests WHERE id=?").bind(std::string_view(id)).step();
  }
  whole.commit();
  return true;
}

int JobStore::waiting() {
  const std::lock_guard lock(mutex_);
  if (!database_) return 0;
  return int(database_->number_of("SELECT COUNT(*) FROM jobs WHERE status=0"));
}

void JobStore::trim(std::int64_t now_ms) {
  const std::lock_guard lock(mutex_);
  Database& db = database();
  Database::Transaction whole(db);
  const auto erase_each = [&](const char* sql, std::int64_t bound) {
    std::vector<std::string> ids;
    {
      Database::Statement old(db, sql);
      old.bind(bound);
      while (old.step()) ids.push_back(old.text(0));
    }
    for (const std::string& id : ids) db.erase(id);
    return ids.size();
  };
  erase_each("SELECT id FROM jobs WHERE status>1 AND finished_ms<?", now_ms - limits_.keep_ms);
  while (db.number_of("SELECT COALESCE(SUM(bytes), 0) FROM jobs") > limits_.max_bytes &&
         erase_each("SELECT id FROM jobs WHERE status>1 ORDER BY finished_ms, number LIMIT ?", 1) > 0) {
  }
  whole.commit();
}

}  // namespace furnace
