// SQLite as the stores use it: one connection, prepared statements, transactions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace furnace {

// Errors of all: kStorage; kUnprocessable when the file is no database.
// Threads: one at a time. Owns: the connection.
class Sqlite {
 public:
  // A path, or ":memory:". With a write-ahead log and full synchronisation: what was committed stays.
  explicit Sqlite(const std::string& name);

  void run(const char* sql);                // one statement or several, without values
  std::int64_t number_of(const char* sql);  // the first column of the first row; 0 without one
  int changes() const;                      // rows that the last statement changed

  // Threads: one. Owns: the prepared statement. Values are bound in order.
  class Statement {
   public:
    Statement(Sqlite& database, std::string_view sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(std::int64_t value);
    Statement& bind(std::string_view text);
    Statement& bind(const std::optional<std::string>& text);
    Statement& bind_blob(std::string_view bytes);  // which must live until the statement has run
    bool step();                                   // true: there is a row
    void reset();
    std::int64_t number(int column);
    std::string text(int column);

   private:
    Sqlite& database_;
    const std::string sql_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
  };

  // All or nothing: rolled back unless it was committed.
  class Transaction {
   public:
    explicit Transaction(Sqlite& database);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

   private:
    Sqlite& database_;
    bool committed_ = false;
  };

 private:
  [[noreturn]] void refuse(std::string_view doing) const;

  struct Close {
    void operator()(sqlite3* connection) const;
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

}  // namespace furnace
