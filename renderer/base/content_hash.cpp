#include "renderer/base/content_hash.hpp"

#include "renderer/base/byte_hasher.hpp"
#include "renderer/base/check.hpp"

#include <openssl/evp.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace furnace {

namespace {

// One byte before each field, so a number never equals a text of the same bytes.
enum class FieldTag : std::uint8_t { kText = 't', kBytes = 'b', kInteger = 'i', kReal = 'd', kHash = 'h' };

struct Digest {
  EVP_MD_CTX* digest = EVP_MD_CTX_new();

  Digest() { FURNACE_CHECK(digest && EVP_DigestInit_ex(digest, EVP_sha256(), nullptr) == 1, "no SHA-256"); }
  ~Digest() { EVP_MD_CTX_free(digest); }
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  void update(const void* data, std::size_t size) {
    FURNACE_CHECK(EVP_DigestUpdate(digest, data, size) == 1, "SHA-256 refused {} bytes", size);
  }

  ContentHash finish() {
    ContentHash hash;
    unsigned int size = 0;
    const int done = EVP_DigestFinal_ex(digest, hash.bytes.data(), &size);
    FURNACE_CHECK(done == 1 && size == hash.bytes.size(), "SHA-256 gave {} bytes", size);
    return hash;
  }
};

}  // namespace

std::string ContentHash::hex() const {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (std::uint8_t byte : bytes) {
    text.push_back(kDigits[byte >> 4]);
    text.push_back(kDigits[byte & 15]);
  }
  return text;
}

ContentHash hash_bytes(std::span<const std::byte> bytes) {
  ContentHash hash;
  unsigned int size = 0;
  const int done = EVP_Digest(bytes.data(), bytes.size(), hash.bytes.data(), &size, EVP_sha256(), nullptr);
  FURNACE_CHECK(done == 1 && size == hash.bytes.size(), "SHA-256 gave {} bytes", size);
  return hash;
}

struct HashBuilder::Context : Digest {
  void field(FieldTag tag, const void* data, std::uint64_t size) {
    std::uint8_t head[9] = {static_cast<std::uint8_t>(tag)};
    for (int i = 0; i < 8; ++i) head[1 + i] = static_cast<std::uint8_t>(size >> (8 * i));
    update(head, sizeof(head));
    update(data, size);
  }

  void field(FieldTag tag, std::uint64_t bits) {
    std::uint8_t little_endian[8];
    for (int i = 0; i < 8; ++i) little_endian[i] = static_cast<std::uint8_t>(bits >> (8 * i));
    field(tag, little_endian, sizeof(little_endian));
  }
};

HashBuilder::HashBuilder() : context_(std::make_unique<Context>()) {}
HashBuilder::~HashBuilder() = default;

HashBuilder& HashBuilder::add(std::string_view text) {
  context_->field(FieldTag::kText, text.data(), text.size());
  return *this;
}

HashBuilder& HashBuilder::add(std::span<const std::byte> bytes) {
  context_->field(FieldTag::kBytes, bytes.data(), bytes.size());
  return *this;
}

HashBuilder& HashBuilder::add(std::int64_t value) {
  context_->field(FieldTag::kInteger, static_cast<std::uint64_t>(value));
  return *this;
}

HashBuilder& HashBuilder::add(double value) {
  if (value == 0) value = 0;  // -0.0
  if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
  context_->field(FieldTag::kReal, std::bit_cast<std::uint64_t>(value));
  return *this;
}

HashBuilder& HashBuilder::add(const ContentHash& hash) {
  context_->field(FieldTag::kHash, hash.bytes.data(), hash.bytes.size());
  return *this;
}

ContentHash HashBuilder::finish() {
  FURNACE_CHECK(context_, "a hash is finished once");
  const ContentHash hash = context_->finish();
  context_.reset();
  return hash;
}

struct ByteHasher::Context : Digest {};

ByteHasher::ByteHasher() : context_(std::make_unique<Context>()) {}
ByteHasher::~ByteHasher() = default;

void ByteHasher::add(std::span<const std::byte> bytes) {
  FURNACE_CHECK(context_, "a hash is finished once");
  context_->update(bytes.data(), bytes.size());
}

ContentHash ByteHasher::finish() {
  FURNACE_CHECK(context_, "a hash is finished once");
  const ContentHash hash = context_->finish();
  context_.reset();
  return hash;
}

}  // namespace furnace

std::size_t std::hash<furnace::ContentHash>::operator()(const furnace::ContentHash& hash) const noexcept {
  std::size_t value;  // SHA-256 is uniform: any of its bytes will do
  std::memcpy(&value, hash.bytes.data(), sizeof(value));
  return value;
}
