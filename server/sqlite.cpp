#include "server/sqlite.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include "renderer/base/error.hpp"

namespace furnace {

void Sqlite::Close::operator()(sqlite3* connection) const {
  sqlite3_close(connection);
}

Sqlite::Sqlite(const std::string& name) {
  sqlite3* connection = nullptr;
  const int outcome = sqlite3_open(name.c_str(), &connection);
  handle_.reset(connection);  // which is there after a failure, too
  if (outcome != SQLITE_OK) refuse("open");
  sqlite3_extended_result_codes(connection, 1);
  constexpr int kBusyMs = 5000;
  sqlite3_busy_timeout(connection, kBusyMs);
  run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;");
}

void Sqlite::refuse(std::string_view doing) const {
  const bool is_foreign = handle_ && sqlite3_errcode(handle_.get()) == SQLITE_NOTADB;
  fail(is_foreign ? ErrorCode::kUnprocessable : ErrorCode::kStorage,
       "The list of jobs could not be read or written.", {},
       fmt::format("{}: {}", doing, handle_ ? sqlite3_errmsg(handle_.get()) : "out of memory"));
}

void Sqlite::run(const char* sql) {
  if (sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) refuse(sql);
}

std::int64_t Sqlite::number_of(const char* sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.number(0) : 0;
}

int Sqlite::changes() const {
  return sqlite3_changes(handle_.get());
}

Sqlite::Statement::Statement(Sqlite& database, std::string_view sql) : database_(database), sql_(sql) {
  if (sqlite3_prepare_v2(database.handle_.get(), sql_.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
    database.refuse(sql_);
}

Sqlite::Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Sqlite::Statement& Sqlite::Statement::bind(std::int64_t value) {
  sqlite3_bind_int64(statement_, ++bound_, value);
  return *this;
}

Sqlite::Statement& Sqlite::Statement::bind(std::string_view text) {
  sqlite3_bind_text64(statement_, ++bound_, text.data() ? text.data() : "", text.size(), SQLITE_TRANSIENT,
                      SQLITE_UTF8);
  return *this;
}

Sqlite::Statement& Sqlite::Statement::bind(const std::optional<std::string>& text) {
  if (text) return bind(std::string_view(*text));
  sqlite3_bind_null(statement_, ++bound_);
  return *this;
}

Sqlite::Statement& Sqlite::Statement::bind_blob(std::string_view bytes) {
  sqlite3_bind_blob64(statement_, ++bound_, bytes.data() ? bytes.data() : "", bytes.size(), SQLITE_STATIC);
  return *this;
}

bool Sqlite::Statement::step() {
  const int outcome = sqlite3_step(statement_);
  if (outcome != SQLITE_ROW && outcome != SQLITE_DONE) database_.refuse(sql_);
  return outcome == SQLITE_ROW;
}

void Sqlite::Statement::reset() {
  sqlite3_reset(statement_);
}

std::int64_t Sqlite::Statement::number(int column) {
  return sqlite3_column_int64(statement_, column);
}

std::string Sqlite::Statement::text(int column) {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  return {bytes ? bytes : "", std::size_t(sqlite3_column_bytes(statement_, column))};
}

Sqlite::Transaction::Transaction(Sqlite& database) : database_(database) {
  database_.run("BEGIN IMMEDIATE");
}

Sqlite::Transaction::~Transaction() {
  if (!committed_) sqlite3_exec(database_.handle_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Sqlite::Transaction::commit() {
  database_.run("COMMIT");
  committed_ = true;
}

}  // namespace furnace
