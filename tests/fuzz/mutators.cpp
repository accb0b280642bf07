#include "tests/fuzz/mutators.hpp"

#include <algorithm>
#include <cstring>
#include <random>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/image/sample_files.hpp"

// libFuzzer's own changes of bytes.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t room);

namespace furnace::fuzz {
namespace {

using Json = nlohmann::json;

std::size_t give_back(const std::string& bytes, std::uint8_t* data, std::size_t room) {
  const std::size_t size = std::min(bytes.size(), room);
  std::memcpy(data, bytes.data(), size);
  return size;
}

std::string mutated_bytes(std::string bytes, std::size_t room) {
  const std::size_t size = bytes.size();
  bytes.resize(std::max(room, size));
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
  return bytes;
}

void collect(Json& value, std::vector<Json*>& all) {
  all.push_back(&value);
  if (!value.is_structured()) return;
  for (Json& member : value) collect(member, all);
}

// Numbers that indices, counts and sizes fear.
Json awkward_number(std::mt19937& random) {
  static const std::vector<Json> kNumbers = {-1,
                                             0,
                                             1,
                                             2,
                                             3,
                                             4,
                                             5,
                                             255,
                                             256,
                                             65535,
                                             65536,
                                             2147483647,
                                             5121,
                                             5125,
                                             4294967295,
                                             4294967296,
                                             9007199254740992,
                                             0.5,
                                             -0.5,
                                             1e-9,
                                             1e38,
                                             -1e308,
                                             1e308};
  return kNumbers[random() % kNumbers.size()];
}

Json changed_scalar(const Json& value, std::mt19937& random) {
  if (value.is_number() && random() % 4 != 0) {
    if (random() % 2 == 0) return awkward_number(random);
    if (value.is_number_integer()) return value.get<std::int64_t>() / 2 + std::int64_t(random() % 4) - 1;
    return value.get<double>() * (double(random() % 9) - 4) / 2;
  }
  if (value.is_string() && random() % 4 != 0) {
    std::string text =
        mutated_bytes(value.get<std::string>(), value.get_ref<const std::string&>().size() + 8);
    for (char& c : text)
      if (static_cast<unsigned char>(c) >= 0x80) c = '?';  // the writer wants UTF-8
    return text;
  }
  if (value.is_boolean() && random() % 4 != 0) return !value.get<bool>();
  static const std::vector<Json> kOthers = {nullptr, true, 0, 1.5, "", "a", Json::array(), Json::object()};
  return kOthers[random() % kOthers.size()];
}

void change_structure(Json& value, const std::vector<Json*>& all, std::mt19937& random) {
  if (value.empty()) return;
  auto member = value.begin();
  std::advance(member, random() % value.size());
  switch (random() % 3) {
    case 0:
      value.erase(member);
      return;
    case 1: {
      const Json copy = *all[random() % all.size()];
      *member = copy;
      return;
    }
    default:
      if (value.is_array()) {
        const Json copy = *member;
        value.insert(member, copy);
      } else {
        const Json copy = *member;
        value["name"] = copy;
      }
  }
}

// None of the syntax is lost; what is no JSON changes as plain bytes do.
std::string mutated_json(const std::string& text, std::size_t room, std::mt19937& random) {
  Json document = Json::parse(text, nullptr, false);
  if (document.is_discarded() || random() % 8 == 0) return mutated_bytes(text, room);
  for (unsigned edits = 1 + unsigned(random() % 3); edits > 0; --edits) {
    std::vector<Json*> all;
    collect(document, all);
    Json& value = *all[random() % all.size()];
    if (value.is_structured()) {
      change_structure(value, all, random);
    } else {
      value = changed_scalar(value, random);
    }
  }
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string string_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  if (at + sizeof word <= bytes.size()) std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

std::string word(std::size_t value) {
  const auto number = std::uint32_t(value);
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

}  // namespace

std::size_t mutate_bytes(std::uint8_t* data, std::size_t size, std::size_t room, unsigned) {
  return LLVMFuzzerMutate(data, size, room);
}

std::size_t mutate_png(std::uint8_t* data, std::size_t size, std::size_t room, unsigned seed) {
  size = LLVMFuzzerMutate(data, size, room);
  if (seed % 16 == 0) return size;
  return give_back(sample::with_right_checksums(string_of(data, size)), data, room);
}

std::size_t mutate_json(std::uint8_t* data, std::size_t size, std::size_t room, unsigned seed) {
  std::mt19937 random(seed);
  return give_back(mutated_json(string_of(data, size), room, random), data, room);
}

std::size_t mutate_json_pair(std::uint8_t* data, std::size_t size, std::size_t room, unsigned seed) {
  std::mt19937 random(seed);
  const TextPair texts = split(std::as_bytes(std::span(data, size)));
  std::string first(texts.first), second(texts.second);
  const std::size_t others = room - std::min(room, size);
  if (random() % 4 == 0) {
    second = mutated_bytes(second, second.size() + others);
  } else {
    first = mutated_json(first, first.size() + others, random);
  }
  return give_back(first + '\0' + second, data, room);
}

// Twelve bytes of header, eight before each chunk.
std::size_t mutate_glb(std::uint8_t* data, std::size_t size, std::size_t room, unsigned seed) {
  std::mt19937 random(seed);
  const std::string file = string_of(data, size);
  const std::size_t json_bytes = word_at(file, 12);
  if (random() % 4 == 0 || file.size() < 20 || json_bytes > file.size() - 20)
    return LLVMFuzzerMutate(data, size, room);
  std::string json =
      mutated_json(file.substr(20, json_bytes), json_bytes + room - std::min(room, size), random);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string rest = file.substr(20 + json_bytes);
  return give_back(file.substr(0, 8) + word(20 + json.size() + rest.size()) + word(json.size()) +
                       file.substr(16, 4) + json + rest,
                   data, room);
}

}  // namespace furnace::fuzz
