// The log: one JSON object per line on stderr. Events are dotted constants, facts are fields; nobody builds
// sentences.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

namespace furnace::log {

enum class Level { kDebug, kInfo, kWarning, kError, kOff };

// Text that is not UTF-8 is written with U+FFFD for each bad byte; a number that is not finite as null.
struct Field {
  std::string_view key;
  std::variant<std::string, std::int64_t, double, bool> value;

  Field(std::string_view name, std::string text) : key(name), value(std::move(text)) {}
  Field(std::string_view name, std::string_view text) : key(name), value(std::string(text)) {}
  Field(std::string_view name, const char* text) : key(name), value(std::string(text)) {}
  Field(std::string_view name, std::integral auto number)
      : key(name), value(static_cast<std::int64_t>(number)) {}
  Field(std::string_view name, bool flag) : key(name), value(flag) {}
  Field(std::string_view name, double number) : key(name), value(number) {}
};

void set_level(Level level);  // default kInfo

// Example: log::info("render.done", {{"width", 512}, {"ms", 12.5}});
// Threads: any; a line is written whole.
void debug(std::string_view event, std::initializer_list<Field> fields = {});
void info(std::string_view event, std::initializer_list<Field> fields = {});
void warning(std::string_view event, std::initializer_list<Field> fields = {});
void error(std::string_view event, std::initializer_list<Field> fields = {});

// Whom a thread works for, as fields of its lines; empty ones are left out. The two ids of a trace are named as OpenTelemetry
// names them in logs.
struct Origin {
  std::string_view request;            // id
  std::string_view trace_id, span_id;  // 32 and 16 lower-case hexadecimal digits
};

// The origin of every line until the scope ends, which its texts must outlive. WorkerPool and ConfinedThread carry it along to
// the thread that does the work. Threads: stays on its own.
class RequestScope {
 public:
  explicit RequestScope(const Origin& origin);
  ~RequestScope();
  RequestScope(const RequestScope&) = delete;
  RequestScope& operator=(const RequestScope&) = delete;

 private:
  Origin previous_;
};

const Origin& origin();  // of the calling thread; empty outside of any scope

}  // namespace furnace::log
