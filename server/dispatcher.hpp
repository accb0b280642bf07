// From a request to its reply: which route, which headers, and the one place where errors become problem
// documents.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/error.hpp"
#include "server/access.hpp"
#include "server/framing.hpp"
#include "server/http_types.hpp"

namespace furnace {

struct Entry;
class Gate;
class Metrics;

// What becomes of a body that is yet to come.
struct Incoming {
  std::shared_ptr<BodySink> sink = {};  // takes it; null: it is held in memory
  std::int64_t max_bytes = 0;           // what a sink takes
  bool is_unwanted = false;             // the handler answers without it
};

struct Route {
  std::string_view method;  // "GET" answers HEAD too
  std::string_view path;    // exact; with "/*" at its end everything below
  std::function<Reply(const Request&)> handler;
  Scopes scopes = scope::kAdmin;                              // whoever forgets to say it has said the safest
  bool draws = false;                                         // counts as a render of a key's day
  std::function<Incoming(const Request& head)> receive = {};  // none: the body is held in memory
};

// Threads: any. Owns: the route table; Metrics and Gate outlive it.
class Dispatcher {
 public:
  // Without a gate whoever comes may use every route.
  Dispatcher(std::vector<Route> routes, Metrics& metrics, Gate* gate = nullptr);

  // What to do with the body of a request of which the head has come; finds its client. Never throws: what a route refuses here, its handler
  // refuses again, without the body.
  Incoming receive(Request& head) const;

  // Finds the request's client first. Never throws: whatever a handler throws becomes a problem document.
  Reply handle(Request request) const;

  // What is wrong with a request before a route could see it: broken syntax (400), too long (413, 414, 431),
  // too slow (408), ...
  Reply refuse(const Request& request, const Refusal& refusal) const;

  // The reply to a connection for which there is no thread.
  Reply overloaded() const;
  // The reply to plain HTTP where TLS is spoken.
  Reply needs_tls() const;

 private:
  const Route* route_of(const Request& request) const;
  const Route& find(const Request& request) const;
  std::string allowed_methods(std::string_view path) const;
  Reply answer(Request& request, std::string_view& route, Entry& entry) const;
  Reply refused(const Request& request, const Refusal& refusal) const;
  void add_common_headers(Reply& reply, const Request& request) const;
  Reply problem(const Request& request, const Error& error) const;
  Reply without_request(ErrorCode code, std::string message) const;

  std::vector<Route> routes_;
  Metrics& metrics_;
  Gate* gate_;
};

}  // namespace furnace
