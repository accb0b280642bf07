// Loaded before the server's libraries (LD_PRELOAD), so that a test may break what the server stands on: its disk, its clock,
// its GPU. Built for tests only; the server knows nothing of it.
//
// FAULTS_CONTROL names a file of eight 64-bit numbers, which both sides have mapped; FAULTS_FOLDER is what counts as the disk.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>

namespace {

// The order is that of tests/http/fault_support.py.
struct Control {
  std::int64_t disk_errno;      // what changes of the disk answer: ENOSPC, EROFS; 0: they are made
  std::int64_t clock_offset_s;  // added to the wall clock
  std::int64_t resets;          // so many questions for a reset of the GPU are answered with one
  std::int64_t hang_ms;         // the next glFinish takes so long
  std::int64_t steps_to_kill;   // the change of the disk that ends the process, half done; 0: none does
  std::int64_t steps;           // changes of the disk, counted here
  std::int64_t refusals;        // of these, so many were refused
  std::int64_t unused;
};

Control none{};
Control* control = &none;
std::string_view folder;

__attribute__((constructor)) void attach() {
  const char* const path = std::getenv("FAULTS_CONTROL");
  const char* const below = std::getenv("FAULTS_FOLDER");
  if (path == nullptr || below == nullptr) return;
  const int file = ::open(path, O_RDWR | O_CLOEXEC);
  void* const memory = ::mmap(nullptr, sizeof(Control), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) std::abort();
  ::close(file);
  control = static_cast<Control*>(memory);
  folder = below;
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

std::int64_t load(const std::int64_t& field) {
  return __atomic_load_n(&field, __ATOMIC_SEQ_CST);
}

// Takes one of `field`; its value before.
std::int64_t take_one(std::int64_t& field) {
  std::int64_t left = load(field);
  while (left > 0 &&
         !__atomic_compare_exchange_n(&field, &left, left - 1, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST)) {
  }
  return left;
}

bool is_below(std::string_view path) {
  return !folder.empty() && path.starts_with(folder);
}

bool is_below(int file) {
  if (folder.empty()) return false;
  char link[32], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t size = ::readlink(link, path, sizeof path);
  return size > 0 && is_below(std::string_view(path, std::size_t(size)));
}

// A change of the disk begins. `before_the_end` does what a process that is killed just now has done of it.
// False, with errno: it is refused.
template <class Half>
bool may_change(bool takes_room, Half before_the_end) {
  __atomic_add_fetch(&control->steps, 1, __ATOMIC_SEQ_CST);
  if (take_one(control->steps_to_kill) == 1) {
    before_the_end();
    ::kill(::getpid(), SIGKILL);
    for (;;) ::pause();
  }
  const std::int64_t refusal = load(control->disk_errno);
  if (refusal == 0 || (refusal == ENOSPC && !takes_room)) return true;
  __atomic_add_fetch(&control->refusals, 1, __ATOMIC_SEQ_CST);
  errno = int(refusal);
  return false;
}

bool may_change(bool takes_room) {
  return may_change(takes_room, [] {});
}

int open_file(const char* name, const char* path, int flags, mode_t mode) {
  const auto next = real<int(const char*, int, ...)>(name);
  const bool changes = (flags & O_ACCMODE) != O_RDONLY;
  if (changes && is_below(path)) {
    struct stat status {};
    const bool is_new = (flags & O_CREAT) != 0 && ::stat(path, &status) != 0;
    if ((is_new || load(control->disk_errno) == EROFS) && !may_change(true)) return -1;
  }
  return next(path, flags, mode);
}

template <class Write>
ssize_t write_to(int file, std::size_t size, Write write) {
  if (is_below(file) && !may_change(true, [&] { write(size / 2); })) return -1;
  return write(size);
}

template <class Call>
int change(bool concerned, bool takes_room, Call call) {
  return concerned && !may_change(takes_room) ? -1 : call();
}

}  // namespace

extern "C" {

// --- the disk --------------------------------------------------------------------------------------------------------

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const auto mode = (flags & O_CREAT) != 0 ? mode_t(va_arg(more, int)) : mode_t(0);
  va_end(more);
  return open_file("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const auto mode = (flags & O_CREAT) != 0 ? mode_t(va_arg(more, int)) : mode_t(0);
  va_end(more);
  return open_file("open64", path, flags, mode);
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  const auto next = real<ssize_t(int, const void*, std::size_t)>("write");
  return write_to(file, size, [&](std::size_t count) { return next(file, bytes, count); });
}

ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) {
  const auto next = real<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
  return write_to(file, size, [&](std::size_t count) { return next(file, bytes, count, offset); });
}

ssize_t pwrite64(int file, const void* bytes, std::size_t size, off64_t offset) {
  const auto next = real<ssize_t(int, const void*, std::size_t, off64_t)>("pwrite64");
  return write_to(file, size, [&](std::size_t count) { return next(file, bytes, count, offset); });
}

int ftruncate(int file, off_t size) noexcept {
  return change(is_below(file), size > 0, [&] { return real<int(int, off_t)>("ftruncate")(file, size); });
}

int ftruncate64(int file, off64_t size) noexcept {
  return change(is_below(file), size > 0, [&] { return real<int(int, off64_t)>("ftruncate64")(file, size); });
}

int fsync(int file) {
  return change(is_below(file), true, [&] { return real<int(int)>("fsync")(file); });
}

int fdatasync(int file) {
  return change(is_below(file), true, [&] { return real<int(int)>("fdatasync")(file); });
}

int rename(const char* from, const char* to) noexcept {
  return change(is_below(to), true, [&] { return real<int(const char*, const char*)>("rename")(from, to); });
}

int mkdir(const char* path, mode_t mode) noexcept {
  struct stat status {};
  const bool is_new = is_below(path) && ::stat(path, &status) != 0;
  return change(is_new, true, [&] { return real<int(const char*, mode_t)>("mkdir")(path, mode); });
}

int unlink(const char* path) noexcept {
  return change(is_below(path), false, [&] { return real<int(const char*)>("unlink")(path); });
}

int remove(const char* path) noexcept {
  return change(is_below(path), false, [&] { return real<int(const char*)>("remove")(path); });
}

int access(const char* path, int wanted) noexcept {
  if ((wanted & W_OK) != 0 && load(control->disk_errno) == EROFS && is_below(path)) {
    errno = EROFS;
    return -1;
  }
  return real<int(const char*, int)>("access")(path, wanted);
}

// --- the wall clock --------------------------------------------------------------------------------------------------

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const int outcome = real<int(clockid_t, timespec*)>("clock_gettime")(clock, time);
  if (clock == CLOCK_REALTIME && outcome == 0) time->tv_sec += load(control->clock_offset_s);
  return outcome;
}

int gettimeofday(timeval* time, void* zone) noexcept {
  const int outcome = real<int(timeval*, void*)>("gettimeofday")(time, zone);
  if (outcome == 0) time->tv_sec += load(control->clock_offset_s);
  return outcome;
}

std::time_t time(std::time_t* out) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (out != nullptr) *out = now.tv_sec;
  return now.tv_sec;
}

// --- the GPU ---------------------------------------------------------------------------------------------------------

unsigned glGetGraphicsResetStatus() {
  constexpr unsigned kUnknownContextReset = 0x8255;
  if (take_one(control->resets) > 0) return kUnknownContextReset;
  return real<unsigned()>("glGetGraphicsResetStatus")();
}

void glFinish() {
  const std::int64_t ms = __atomic_exchange_n(&control->hang_ms, 0, __ATOMIC_SEQ_CST);
  if (ms > 0) ::usleep(useconds_t(ms * 1000));
  real<void()>("glFinish")();
}

}  // extern "C"
