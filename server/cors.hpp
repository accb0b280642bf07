// Which pages of other origins may call the API from a browser (the Fetch standard's CORS protocol).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http_types.hpp"

namespace furnace {

// Threads: immutable. Owns: the origins.
class Cors {
 public:
  Cors() = default;  // none
  // Origins separated by ",", or "*". Expects what fault() has nothing against.
  explicit Cors(std::string_view list);
  static std::string fault(std::string_view list);

  // On every reply: whether the page that asks may read it.
  void add(Reply& reply, const Request& request) const;
  // On the reply to OPTIONS, when a browser asks before it sends: `methods` of that path.
  void add_preflight(Reply& reply, const Request& request, const std::string& methods) const;

 private:
  bool allows(std::string_view origin) const;

  std::vector<std::string> origins_;
  bool all_ = false;
};

}  // namespace furnace
