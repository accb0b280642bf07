#include "renderer/decode/worker.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <new>
#include <optional>
#include <string_view>

#include "renderer/decode/sandbox.hpp"

namespace furnace::decode {
namespace {

constexpr int kWrongUsage = 2;
constexpr std::array kJobs = {job_row<TextureJob>(), job_row<EnvironmentJob>(), job_row<DracoJob>(),
                              job_row<MeshoptJob>(), job_row<ModelJob>()};

template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

// None: the parent speaks of something else than this program knows.
std::optional<std::string> answer(const Message& message, std::span<const JobRow> jobs) {
  constexpr std::size_t kDescriptors = 2;
  Request request;
  WireReader arguments(message.bytes);
  fields(arguments, request);
  const auto row = std::ranges::find(jobs, request.kind, &JobRow::kind);
  if (request.magic != kMagic || row == jobs.end() || message.descriptors.size() != kDescriptors)
    return std::nullopt;
  const Mapping file(message.descriptors[0].get(), request.file_bytes, Mapping::Access::kRead);
  const Mapping block(message.descriptors[1].get(), request.block_bytes, Mapping::Access::kWrite);
  if (!file.is_there() || !block.is_there()) return std::nullopt;

  Reply reply;
  reply.serial = request.serial;
  WireWriter result(block.bytes());
  try {
    if (!row->run(arguments, file.bytes(), result)) return std::nullopt;
  } catch (const Error& error) {
    reply.failed = true;
    reply.error = error;
  } catch (const std::bad_alloc&) {
    reply.failed = true;
    reply.error = {
        ErrorCode::kUnprocessable, "the file needs more memory than a decoder may use", {}, {}, {}, {}};
  }
  WireWriter head;
  fields(head, reply);
  return reply.failed ? head.bytes() : head.bytes() + result.bytes();
}

}  // namespace

std::span<const JobRow> decode_jobs() {
  return kJobs;
}

int run_worker(std::span<char* const> argv, std::span<const JobRow> jobs) {
  if (argv.size() != 2) return kWrongUsage;
  const auto socket = number_of<int>(argv[0]);
  const auto memory_bytes = number_of<std::int64_t>(argv[1]);
  if (!socket || !memory_bytes) return kWrongUsage;
  Hello hello;
  hello.problem = enter_sandbox(*socket, {*memory_bytes});
  WireWriter greeting;
  fields(greeting, hello);
  if (!send_message(*socket, greeting.bytes())) return kWrongUsage;
  while (const auto message = receive_message(*socket, 2)) {
    const auto reply = answer(*message, jobs);
    if (!reply || !send_message(*socket, *reply)) std::_Exit(EXIT_FAILURE);
  }
  // What ends a process in order writes and closes, which is not allowed any more.
  std::_Exit(EXIT_SUCCESS);
}

}  // namespace furnace::decode
