#include "server/tls.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include <fcntl.h>

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/key_lines.hpp"

namespace furnace {
namespace {

// RFC 9325, 4.2: forward secrecy and authenticated encryption; TLS 1.3 has nothing else.
constexpr const char* kCiphersOfTls12 = "ECDHE+AESGCM:ECDHE+CHACHA20";

struct Free {
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

std::string last_reason() {
  const unsigned long code = ERR_get_error();
  const char* const reason = ERR_reason_error_string(code);
  ERR_clear_error();
  return reason != nullptr ? reason : fmt::format("error {}", code);
}

[[noreturn]] void refuse(const std::filesystem::path& file, std::string_view what) {
  fail(ErrorCode::kUnprocessable, fmt::format("{} {}", file.string(), what), {}, last_reason());
}

Owned<BIO> bytes_of(const std::string& text) {
  return Owned<BIO>(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

// A passphrase would be asked for at the terminal.
int no_passphrase(char*, int, int, void*) {
  return -1;
}

void use_certificate(SSL_CTX& context, const std::filesystem::path& file) {
  const std::string text = read_key_file(file, false);
  const Owned<BIO> pem = bytes_of(text);
  const Owned<X509> own(PEM_read_bio_X509_AUX(pem.get(), nullptr, no_passphrase, nullptr));
  if (!own || SSL_CTX_use_certificate(&context, own.get()) != 1)
    refuse(file, "does not begin with a certificate in PEM");
  if (X509_cmp_current_time(X509_get0_notAfter(own.get())) < 0)
    log::warning("tls.certificate_expired", {{"path", file.string()}});
  for (;;) {
    Owned<X509> next(PEM_read_bio_X509(pem.get(), nullptr, no_passphrase, nullptr));
    if (!next) break;
    if (SSL_CTX_add1_chain_cert(&context, next.get()) != 1) refuse(file, "has a chain that cannot be used");
  }
  if (ERR_GET_REASON(ERR_peek_last_error()) != PEM_R_NO_START_LINE) refuse(file, "is damaged");
  ERR_clear_error();
}

void use_key(SSL_CTX& context, const std::filesystem::path& file) {
  const std::string text = read_key_file(file, true);
  const Owned<EVP_PKEY> key(PEM_read_bio_PrivateKey(bytes_of(text).get(), nullptr, no_passphrase, nullptr));
  if (!key) refuse(file, "is not a private key in PEM without a passphrase");
  if (SSL_CTX_use_PrivateKey(&context, key.get()) != 1 || SSL_CTX_check_private_key(&context) != 1)
    refuse(file, "is not the key of the certificate");
}

// RFC 7301: who offers protocols, and not this one, is refused.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* size, const unsigned char* offered,
                    unsigned int offered_size, void*) {
  constexpr std::string_view kHttp11 = "http/1.1";
  std::string_view list(reinterpret_cast<const char*>(offered), offered_size);
  while (!list.empty()) {
    const std::size_t length = static_cast<unsigned char>(list.front());
    const std::string_view name = list.substr(1, length);
    if (name == kHttp11) {
      *chosen = reinterpret_cast<const unsigned char*>(name.data());
      *size = static_cast<unsigned char>(name.size());
      return SSL_TLSEXT_ERR_OK;
    }
    list.remove_prefix(std::min(list.size(), length + 1));
  }
  return SSL_TLSEXT_ERR_ALERT_FATAL;
}

std::shared_ptr<SSL_CTX> context_of(const TlsFiles& files) {
  ERR_clear_error();
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context || SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) != 1 ||
      SSL_CTX_set_cipher_list(context.get(), kCiphersOfTls12) != 1)
    fail(ErrorCode::kInternal, "libssl cannot be set up", {}, last_reason());
  SSL_CTX_set_options(context.get(),
                      SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                      SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_alpn_select_cb(context.get(), choose_protocol, nullptr);
  use_certificate(*context, files.certificate);
  use_key(*context, files.key);
  return context;
}

}  // namespace

TlsCertificate::TlsCertificate(TlsFiles files) : files_(std::move(files)), context_(context_of(files_)) {}

void TlsCertificate::reload() {
  std::shared_ptr<SSL_CTX> context = context_of(files_);
  const std::lock_guard lock(mutex_);
  context_ = std::move(context);
}

std::unique_ptr<TlsSession> TlsCertificate::session(int socket) const {
  ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
  const std::lock_guard lock(mutex_);
  return std::make_unique<TlsSession>(*context_, socket);
}

TlsSession::TlsSession(SSL_CTX& context, int socket) : ssl_(SSL_new(&context)) {
  if (ssl_ == nullptr || SSL_set_fd(ssl_, socket) != 1)
    fail(ErrorCode::kInternal, "libssl has no room for a connection", {}, last_reason());
  SSL_set_accept_state(ssl_);
}

TlsSession::~TlsSession() {
  end();
  SSL_free(ssl_);
}

TlsSession::Progress TlsSession::progress_of(int outcome, std::size_t bytes) {
  if (outcome > 0) return {Step::kMoved, bytes};
  switch (SSL_get_error(ssl_, outcome)) {
    case SSL_ERROR_WANT_READ:
      return {Step::kWantsInput};
    case SSL_ERROR_WANT_WRITE:
      return {Step::kWantsOutput};
    case SSL_ERROR_ZERO_RETURN:
      return {Step::kEnded};
    default:
      is_open_ = false;
      return {Step::kEnded};
  }
}

TlsSession::Progress TlsSession::handshake() {
  ERR_clear_error();
  const Progress progress = progress_of(SSL_accept(ssl_), 0);
  is_open_ = progress.step == Step::kMoved;
  met_plain_http_ = progress.step == Step::kEnded && ERR_GET_REASON(ERR_peek_error()) == SSL_R_HTTP_REQUEST;
  if (progress.step == Step::kEnded) log::debug("tls.handshake_failed", {{"reason", last_reason()}});
  return progress;
}

TlsSession::Progress TlsSession::read(char* out, std::size_t size) {
  ERR_clear_error();
  std::size_t got = 0;
  const int outcome = SSL_read_ex(ssl_, out, size, &got);
  return progress_of(outcome, got);
}

// To a client that has left it raises SIGPIPE, which the HTTP library has the process ignore.
TlsSession::Progress TlsSession::write(const char* data, std::size_t size) {
  ERR_clear_error();
  std::size_t sent = 0;
  const int outcome = SSL_write_ex(ssl_, data, size, &sent);
  return progress_of(outcome, sent);
}

void TlsSession::end() {
  if (!std::exchange(is_open_, false)) return;
  ERR_clear_error();
  SSL_shutdown(ssl_);
}

bool TlsSession::has_unread() const {
  return SSL_pending(ssl_) > 0;
}

}  // namespace furnace
