// The child's side: a loop that decodes what it is sent, one file at a time, on one thread.
#pragma once

#include <span>
#include <string>

#include "renderer/base/error.hpp"
#include "renderer/decode/channel.hpp"
#include "renderer/decode/messages.hpp"

namespace furnace::decode {

// A kind of job and how it is done.
struct JobRow {
  JobKind kind;
  // Reads the arguments, decodes, writes the result. False: the arguments are not of this job, or the result does not fit.
  // Errors: those of the job.
  bool (*run)(WireReader& arguments, Bytes file, WireWriter& result);
};

template <class Job>
bool run_job(WireReader& arguments, Bytes file, WireWriter& result) {
  Job job;
  fields(arguments, job);
  if (!arguments.ended_well()) return false;
  const typename Job::Result made = job.run(file);
  fields(result, made);
  return result.fits();
}

template <class Job>
constexpr JobRow job_row() {
  return {Job::kKind, &run_job<Job>};
}

// Every job of the program.
std::span<const JobRow> decode_jobs();

// `argv` as WorkerCommand makes it: the socket's number, the memory in bytes. Sandboxes the process, answers until the
// parent hangs up, and returns the exit status. Threads: the only one of the process.
int run_worker(std::span<char* const> argv, std::span<const JobRow> jobs);

}  // namespace furnace::decode
