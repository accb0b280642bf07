// ETC1S pictures with every kind of prediction, run and history, and what they show.
#pragma once

#include "tests/image/ktx2_files.hpp"
#include "tests/image/sample_files.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace furnace::sample {

inline constexpr unsigned kEndpoints = 40, kSelectors = 50, kHistory = 8;

// Codes of one length for 2^length symbols, sent as one length and runs of it.
inline void put_table(unsigned length, BitWriter& out) {
  constexpr int kOrder[] = {17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16};
  unsigned left = 1u << length;
  out.put(left, 14);
  out.put(21, 5);
  for (const int symbol : kOrder) out.put(symbol == int(length) || symbol == 20 ? 1 : 0, 3);
  out.put(0, 1);  // the length itself, the lower of two codes of one bit
  --left;
  while (left > 0) {
    if (left < 7) {
      out.put(0, 1);
      --left;
      continue;
    }
    const unsigned run = std::min(left, 134u);
    out.put(1, 1);
    out.put(run - 7, 7);
    left -= run;
  }
}

inline void put_symbol(unsigned symbol, unsigned length, BitWriter& out) {
  for (unsigned i = length; i-- > 0;) out.put(symbol >> i & 1, 1);
}

inline void put_pieces(std::uint32_t value, unsigned size, BitWriter& out) {
  for (;;) {
    const std::uint32_t rest = value >> size;
    out.put((value & ((1u << size) - 1)) | (rest > 0 ? 1u << size : 0), size + 1);
    if (rest == 0) return;
    value = rest;
  }
}

struct Endpoint {
  int color[3], table;
};

// A random file of one picture and what it shows. Threads: one.
class Etc1sFile {
 public:
  Etc1sFile(unsigned seed, Extent extent) : random_(seed), extent_(extent) {
    for (unsigned i = 0; i < kEndpoints; ++i)
      endpoints_.push_back({{int(next(32)), int(next(32)), int(next(32))}, int(next(8))});
    for (unsigned i = 0; i < kSelectors; ++i) selectors_.push_back(std::uint32_t(random_()));
  }

  std::string slice(std::vector<std::uint8_t>& rgb) {
    const int across = (extent_.width + 3) / 4, down = (extent_.height + 3) / 4;
    plan_predictions(across, down);
    BitWriter out;
    history_.assign(kHistory, 0);
    place_ = kHistory / 2;
    run_ = 0;
    std::vector<unsigned> endpoints(std::size_t(across * down));
    rgb.assign(std::size_t(extent_.area()) * 3, 0);
    unsigned last = 0;
    group_ = repeats_ = 0;
    for (int y = 0; y < down; ++y) {
      for (int x = 0; x < across; ++x) {
        if (x % 2 == 0 && y % 2 == 0) put_prediction(out);
        unsigned& endpoint = endpoints[std::size_t(y * across + x)];
        switch (prediction(x, y, across)) {
          case 0:
            endpoint = last;
            break;
          case 1:
            endpoint = endpoints[std::size_t((y - 1) * across + x)];
            break;
          case 2:
            endpoint = endpoints[std::size_t((y - 1) * across + x - 1)];
            break;
          default:
            endpoint = next(kEndpoints);
            put_symbol((endpoint + kEndpoints - last) % kEndpoints, 6, out);
        }
        last = endpoint;
        paint(endpoints_[endpoint], selectors_[put_selector(out)], x * 4, y * 4, rgb);
      }
    }
    return out.take();
  }

  std::string global_data(const std::vector<std::array<std::uint32_t, 4>>& places) {
    BitWriter endpoints, selectors, tables;
    for (const unsigned length : {5u, 5u, 5u, 3u}) put_table(length, endpoints);
    endpoints.put(0, 1);
    Endpoint last{{16, 16, 16}, 0};
    for (const Endpoint& endpoint : endpoints_) {
      put_symbol(unsigned(endpoint.table - last.table) & 7, 3, endpoints);
      for (int c = 0; c < 3; ++c) put_symbol(unsigned(endpoint.color[c] - last.color[c]) & 31, 5, endpoints);
      last = endpoint;
    }
    selectors.put(0, 3);
    put_table(8, selectors);
    for (std::size_t i = 0; i < selectors_.size(); ++i) {
      for (int row = 0; row < 4; ++row) {
        const unsigned byte = selectors_[i] >> (8 * row) & 255;
        if (i == 0)
          selectors.put(byte, 8);
        else
          put_symbol(byte ^ (selectors_[i - 1] >> (8 * row) & 255), 8, selectors);
      }
    }
    for (const unsigned length : {9u, 6u, 6u, 6u}) put_table(length, tables);
    tables.put(kHistory, 13);
    const std::string parts[] = {endpoints.take(), selectors.take(), tables.take()};
    std::string out;
    sample::put(out, kEndpoints, 2);
    sample::put(out, kSelectors, 2);
    for (const std::string& part : parts) sample::put(out, part.size(), 4);
    sample::put(out, 0, 4);
    for (const auto& place : places) {
      sample::put(out, 0, 4);
      for (const std::uint32_t number : place) sample::put(out, number, 4);
    }
    return out + parts[0] + parts[1] + parts[2];
  }

 private:
  unsigned next(unsigned below) { return sample::next(random_, below); }

  void plan_predictions(int across, int down) {
    groups_.clear();
    for (int y = 0; y < down; y += 2) {
      for (int x = 0; x < across; x += 2) {
        unsigned symbol = 0xff;
        for (unsigned i = 0; i < 4 && next(4) == 0; ++i) {
          const int bx = x + int(i % 2), by = y + int(i / 2);
          unsigned kind = next(4);
          if ((kind == 0 && bx == 0) || (kind == 1 && by == 0) || (kind == 2 && (bx == 0 || by == 0)))
            kind = 3;
          symbol = (symbol & ~(3u << (2 * i))) | kind << (2 * i);
        }
        groups_.push_back(symbol);
      }
    }
  }

  unsigned prediction(int x, int y, int across) const {
    const unsigned symbol = groups_[std::size_t(y / 2 * ((across + 1) / 2) + x / 2)];
    return symbol >> (2 * (x % 2 + 2 * (y % 2))) & 3;
  }

  void put_prediction(BitWriter& out) {
    const std::size_t at = group_++;
    if (repeats_ > 0) {
      --repeats_;
      return;
    }
    unsigned run = 0;
    while (at > 0 && at + run < groups_.size() && groups_[at + run] == groups_[at - 1]) ++run;
    if (run < 3) return put_symbol(groups_[at], 9, out);
    put_symbol(256, 9, out);
    put_pieces(run - 3, 4, out);
    repeats_ = run - 1;
  }

  unsigned put_selector(BitWriter& out) {
    if (run_ > 0) {
      --run_;
      return history_[0];
    }
    const unsigned kind = next(4);
    if (kind == 0) {  // a run of the first
      run_ = next(3) == 0 ? 66 + next(200) : 3 + next(60);
      put_symbol(kSelectors + kHistory, 6, out);
      put_symbol(std::min(run_ - 3, 63u), 6, out);
      if (run_ - 3 >= 63) put_pieces(run_ - 3, 7, out);
      --run_;
      return history_[0];
    }
    if (kind == 1) {
      const unsigned index = next(kHistory), selector = history_[index];
      put_symbol(kSelectors + index, 6, out);
      std::swap(history_[index], history_[index / 2]);
      return selector;
    }
    const unsigned selector = next(kSelectors);
    put_symbol(selector, 6, out);
    history_[place_++] = selector;
    if (place_ == kHistory) place_ = kHistory / 2;
    return selector;
  }

  void paint(const Endpoint& endpoint, std::uint32_t selector, int x0, int y0,
             std::vector<std::uint8_t>& rgb) const {
    constexpr int kSteps[8][2] = {{2, 8},   {5, 17},  {9, 29},   {13, 42},
                                  {18, 60}, {24, 80}, {33, 106}, {47, 183}};
    for (int y = y0; y < std::min(y0 + 4, extent_.height); ++y) {
      for (int x = x0; x < std::min(x0 + 4, extent_.width); ++x) {
        const unsigned code = selector >> (8 * (y - y0) + 2 * (x - x0)) & 3;
        const int* const steps = kSteps[endpoint.table];
        const int step = code == 0 ? -steps[1] : code == 1 ? -steps[0] : code == 2 ? steps[0] : steps[1];
        for (int c = 0; c < 3; ++c) {
          const int base = endpoint.color[c] * 8 + endpoint.color[c] / 4;
          rgb[std::size_t((y * extent_.width + x) * 3 + c)] = std::uint8_t(std::clamp(base + step, 0, 255));
        }
      }
    }
  }

  std::mt19937 random_;
  const Extent extent_;
  std::vector<Endpoint> endpoints_;
  std::vector<std::uint32_t> selectors_;
  std::vector<unsigned> groups_, history_;
  std::size_t group_ = 0, place_ = 0;
  unsigned repeats_ = 0, run_ = 0;
};

inline std::string etc1s_file(unsigned seed, Extent extent, std::vector<std::uint8_t>& rgb,
                              std::vector<std::uint8_t>& second) {
  Etc1sFile file(seed, extent);
  const std::string color = file.slice(rgb), alpha = file.slice(second);
  Ktx2Parts parts;
  parts.vk_format = 0;
  parts.width = std::uint32_t(extent.width), parts.height = std::uint32_t(extent.height);
  parts.scheme = 1;
  parts.model = kDfModelEtc1s;
  parts.channels = {0, 15};
  parts.levels = {color + alpha};
  parts.global_data = file.global_data(
      {{0, std::uint32_t(color.size()), std::uint32_t(color.size()), std::uint32_t(alpha.size())}});
  return ktx2(parts);
}

}  // namespace furnace::sample
