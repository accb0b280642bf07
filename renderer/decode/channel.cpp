#include "renderer/decode/channel.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "renderer/base/error.hpp"
#include "renderer/decode/messages.hpp"

namespace furnace::decode {
namespace {

constexpr std::size_t kMostDescriptors = 2;

[[noreturn]] void fail_system(const char* what) {
  fail(ErrorCode::kInternal, "there is no memory to decode in; try again", {},
       std::string(what) + ": " + std::generic_category().message(errno));
}

Descriptor make_memory(const char* name) {
  Descriptor memory(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory.is_open()) fail_system("memfd_create");
  return memory;
}

void seal(const Descriptor& memory, int seals) {
  if (::fcntl(memory.get(), F_ADD_SEALS, seals | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    fail_system("sealing memory");
}

}  // namespace

Descriptor sealed_copy(std::span<const std::byte> bytes) {
  Descriptor memory = make_memory("furnace-file");
  while (!bytes.empty()) {
    const ssize_t written = ::write(memory.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_system("writing memory");
    bytes = bytes.subspan(std::size_t(written));
  }
  seal(memory, F_SEAL_WRITE);
  return memory;
}

Descriptor empty_block(std::size_t bytes) {
  Descriptor memory = make_memory("furnace-block");
  if (::ftruncate(memory.get(), off_t(bytes)) != 0) fail_system("sizing memory");
  seal(memory, 0);
  return memory;
}

SocketPair make_socket_pair() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) fail_system("socketpair");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

bool send_message(int socket, std::string_view bytes, std::span<const int> descriptors) {
  iovec part{const_cast<char*>(bytes.data()), bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) char control[CMSG_SPACE(kMostDescriptors * sizeof(int))] = {};
  if (!descriptors.empty()) {
    message.msg_control = control;
    message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(head), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == ssize_t(bytes.size());
}

std::optional<Message> receive_message(int socket, std::size_t most_descriptors) {
  Message out;
  out.bytes.resize(kMostMessageBytes);
  iovec part{out.bytes.data(), out.bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  // Without room for them the kernel closes what descriptors a message brings.
  alignas(cmsghdr) char control[CMSG_SPACE(kMostDescriptors * sizeof(int))] = {};
  if (most_descriptors > 0) {
    message.msg_control = control;
    message.msg_controllen = CMSG_SPACE(std::min(most_descriptors, kMostDescriptors) * sizeof(int));
  }
  ssize_t got = 0;
  do {
    got = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  } while (got < 0 && errno == EINTR);
  for (cmsghdr* head = CMSG_FIRSTHDR(&message); got >= 0 && head; head = CMSG_NXTHDR(&message, head)) {
    if (head->cmsg_level != SOL_SOCKET || head->cmsg_type != SCM_RIGHTS) continue;
    for (std::size_t at = 0; at + sizeof(int) <= head->cmsg_len - CMSG_LEN(0); at += sizeof(int)) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(head) + at, sizeof fd);
      out.descriptors.emplace_back(fd);
    }
  }
  if (got <= 0 || (message.msg_flags & MSG_TRUNC) != 0) return std::nullopt;
  out.bytes.resize(std::size_t(got));
  return out;
}

Mapping::Mapping(int fd, std::size_t bytes, Access access) {
  if (bytes == 0) return;
  const bool reads = access == Access::kRead;
  // Before Linux 6.7 what is sealed against writing cannot be mapped shared, not even to read.
  void* begin = ::mmap(nullptr, bytes, reads ? PROT_READ : PROT_READ | PROT_WRITE,
                       reads ? MAP_PRIVATE : MAP_SHARED, fd, 0);
  there_ = begin != MAP_FAILED;
  if (there_) bytes_ = {static_cast<std::byte*>(begin), bytes};
}

Mapping::~Mapping() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

}  // namespace furnace::decode
