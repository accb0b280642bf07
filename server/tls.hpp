// TLS for a listener: a certificate that may be changed while it serves, and the records of one connection. Only tls.cpp knows
// libssl.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>

struct ssl_st;
struct ssl_ctx_st;

namespace furnace {

struct TlsFiles {
  std::filesystem::path certificate;  // PEM: the server's own first, then those that lead to a root
  std::filesystem::path key;          // PEM, without a passphrase, not to be read by others
};

// One connection. Nothing waits: what cannot go on says what it waits for.
// Threads: one at a time. Owns: the connection's keys; the socket is its caller's, and closed after this.
class TlsSession {
 public:
  enum class Step { kMoved, kWantsInput, kWantsOutput, kEnded };
  struct Progress {
    Step step = Step::kEnded;
    std::size_t bytes = 0;  // of kMoved
  };

  TlsSession(ssl_ctx_st& context, int socket);
  ~TlsSession();  // tells the client that no more comes, if it was ever spoken to
  TlsSession(const TlsSession&) = delete;
  TlsSession& operator=(const TlsSession&) = delete;

  Progress handshake();                                    // kMoved: it is done
  bool met_plain_http() const { return met_plain_http_; }  // which ended the handshake
  Progress read(char* out, std::size_t size);
  Progress write(const char* data, std::size_t size);
  void end();               // no more is written
  bool has_unread() const;  // bytes that have left the socket already

 private:
  Progress progress_of(int outcome, std::size_t bytes);

  ssl_st* ssl_;
  bool is_open_ = false, met_plain_http_ = false;
};

// Threads: any. Owns: the certificate in use; connections share the one they began with.
class TlsCertificate {
 public:
  // Errors: those of read_key_file; kUnprocessable for what is no certificate or no key, or when the two do not belong together.
  explicit TlsCertificate(TlsFiles files);

  // Reads the files again, for the connections that begin from now on. On an Error all is as before.
  void reload();

  // Makes the socket one that does not wait.
  std::unique_ptr<TlsSession> session(int socket) const;

 private:
  const TlsFiles files_;
  mutable std::mutex mutex_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace furnace
