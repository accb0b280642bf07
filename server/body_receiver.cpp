#include "server/body_receiver.hpp"

#include <exception>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/problem.hpp"

namespace furnace {

bool BodyReceiver::take(std::string_view piece, Request& request) {
  received_bytes_ += static_cast<std::int64_t>(piece.size());
  if (received_bytes_ > max_bytes_) {
    refusal_ = {413, fmt::format("The body may have {} bytes.", max_bytes_), {}};
    return false;
  }
  return request.sink ? pass_on(piece, *request.sink) : keep(piece, request);
}

bool BodyReceiver::keep(std::string_view piece, Request& request) {
  const auto size = static_cast<std::int64_t>(piece.size());
  held_bytes_ += size;
  if ((all_bytes_ += size) > max_all_bytes_) {
    refusal_ = {429, "Too many large requests at once; try again in a moment.", {}};
    return false;
  }
  request.body.append(piece);
  return true;
}

// Nothing may be thrown through the HTTP library.
bool BodyReceiver::pass_on(std::string_view piece, BodySink& sink) {
  Error error;
  try {
    sink.take(piece);
    return true;
  } catch (const Error& known) {
    error = known;
  } catch (const std::exception& stray) {
    error = {ErrorCode::kInternal, "The body could not be kept.", {}, stray.what(), {}, {}};
  }
  refusal_ = {api::http_status(error.code), error.message, error};
  return false;
}

void BodyReceiver::give_room_back() {
  all_bytes_ -= std::exchange(held_bytes_, 0);
}

}  // namespace furnace
