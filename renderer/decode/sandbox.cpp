#include "renderer/decode/sandbox.hpp"

#include <fcntl.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <initializer_list>
#include <memory>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "renderer/base/descriptor.hpp"

namespace furnace::decode {
namespace {

// The sanitizers' own memory is terabytes of address space.
#ifdef FURNACE_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

// Received descriptors need numbers: the socket's, and two more.
constexpr rlim_t kMostDescriptors = 16;
// Backstop for what RLIMIT_DATA does not count; shared memory of one job is below 4 GiB.
constexpr rlim_t kMostSharedBytes = 8ull << 30;

std::string problem_of(const char* what, int error) {
  return fmt::format("{}: {}", what, std::generic_category().message(error));
}

std::string limit(int resource, rlim_t most, const char* name) {
  const rlimit value{most, most};
  return ::setrlimit(__rlimit_resource(resource), &value) == 0 ? std::string() : problem_of(name, errno);
}

std::string limit_resources(const SandboxLimits& limits) {
  std::string problem;
  const auto add = [&](int resource, rlim_t most, const char* name) {
    if (problem.empty()) problem = limit(resource, most, name);
  };
  add(RLIMIT_CORE, 0, "RLIMIT_CORE");
  add(RLIMIT_FSIZE, 0, "RLIMIT_FSIZE");
  add(RLIMIT_NPROC, 0, "RLIMIT_NPROC");
  add(RLIMIT_NOFILE, kMostDescriptors, "RLIMIT_NOFILE");
  if (kSanitized) return problem;
  const auto memory = rlim_t(limits.memory_bytes);
  add(RLIMIT_DATA, memory, "RLIMIT_DATA");
  add(RLIMIT_AS, memory + kMostSharedBytes, "RLIMIT_AS");
  return problem;
}

// Where memory is short the system should end this process, not the server. It is a wish: who cannot tell it goes on.
void volunteer_for_oom() {
  constexpr std::string_view kSooner = "500";
  const Descriptor file(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  if (file.is_open() && ::write(file.get(), kSooner.data(), kSooner.size()) < 0) return;
}

std::string give_up_privileges() {
  ::prctl(PR_SET_NAME, "furnace-decode");  // else it is called "exe"
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return problem_of("PR_SET_PDEATHSIG", errno);
  if (::prctl(PR_SET_DUMPABLE, 0) != 0) return problem_of("PR_SET_DUMPABLE", errno);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return problem_of("PR_SET_NO_NEW_PRIVS", errno);
  return {};
}

// Threads: one. Owns: a filter that is being made; the first fault is kept.
class Filter {
 public:
  Filter() : context_(::seccomp_init(SCMP_ACT_KILL_PROCESS), &::seccomp_release) {}

  void allow(std::initializer_list<int> calls) {
    for (const int call : calls) allow_if(call, {});
  }
  void allow_if(int call, std::initializer_list<scmp_arg_cmp> conditions) {
    if (fault_ != 0 || !context_) return;
    fault_ = ::seccomp_rule_add_array(context_.get(), SCMP_ACT_ALLOW, call, unsigned(conditions.size()),
                                      conditions.begin());
  }
  std::string load() {
    if (!context_) return "this system has no system call filters (seccomp)";
    if (fault_ == 0) fault_ = ::seccomp_load(context_.get());
    return fault_ == 0 ? std::string() : problem_of("system call filter", -fault_);
  }

 private:
  std::unique_ptr<void, void (*)(scmp_filter_ctx)> context_;
  int fault_ = 0;
};

void allow_memory(Filter& filter) {
  filter.allow({SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise)});
  const scmp_arg_cmp not_code = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
  filter.allow_if(SCMP_SYS(mprotect), {not_code});
  // Own memory is what RLIMIT_DATA counts; shared memory is what the parent gave.
  filter.allow_if(SCMP_SYS(mmap),
                  {not_code, SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_TYPE | MAP_GROWSDOWN, MAP_PRIVATE)});
  filter.allow_if(SCMP_SYS(mmap),
                  {not_code, SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_TYPE | MAP_ANONYMOUS, MAP_SHARED)});
}

std::string filter_calls(int socket) {
  Filter filter;
  allow_memory(filter);
  const scmp_arg_cmp to_parent = SCMP_A0(SCMP_CMP_EQ, scmp_datum_t(socket), 0);
  filter.allow_if(SCMP_SYS(recvmsg), {to_parent});
  filter.allow_if(SCMP_SYS(sendmsg), {to_parent});
  filter.allow({SCMP_SYS(close), SCMP_SYS(futex), SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),
                SCMP_SYS(getrandom), SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(rt_sigprocmask),
                SCMP_SYS(rt_sigreturn), SCMP_SYS(restart_syscall), SCMP_SYS(exit), SCMP_SYS(exit_group)});
  // abort() says what failed and signals itself.
  filter.allow_if(SCMP_SYS(write), {SCMP_A0(SCMP_CMP_EQ, STDERR_FILENO, 0)});
  filter.allow_if(SCMP_SYS(tgkill), {SCMP_A0(SCMP_CMP_EQ, scmp_datum_t(::getpid()), 0)});
  if (kSanitized) filter.allow({SCMP_SYS(sigaltstack), SCMP_SYS(sched_yield), SCMP_SYS(getrusage)});
  return filter.load();
}

}  // namespace

std::string enter_sandbox(int socket, const SandboxLimits& limits) {
  // Who stops a whole group of processes means the parent, which lets its work end.
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGQUIT}) ::signal(number, SIG_IGN);
  volunteer_for_oom();
  std::string problem = limit_resources(limits);
  if (problem.empty()) problem = give_up_privileges();
  // The filter is worth having even where something else is missing.
  const std::string unfiltered = filter_calls(socket);
  return problem.empty() ? unfiltered : problem;
}

}  // namespace furnace::decode
