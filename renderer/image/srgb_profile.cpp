#include "renderer/image/srgb_profile.hpp"

#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace furnace {
namespace {

void append_u32(std::string& out, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<char>(value >> shift));
}

// ICC.1:2010, 4.6: sixteen bits, binary point, sixteen bits.
void append_fixed(std::string& out, double value) {
  append_u32(out, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536))));
}

std::string numbers(std::string_view type, std::initializer_list<double> values) {
  std::string tag(type);
  append_u32(tag, 0);
  for (const double value : values) append_fixed(tag, value);
  return tag;
}

// ICC.1:2010, 10.13: one record, American English, UTF-16.
std::string text(std::string_view ascii) {
  constexpr std::uint32_t kRecords = 1, kRecordBytes = 12, kTextAt = 28;
  std::string tag = "mluc";
  append_u32(tag, 0);
  append_u32(tag, kRecords);
  append_u32(tag, kRecordBytes);
  tag += "enUS";
  append_u32(tag, static_cast<std::uint32_t>(2 * ascii.size()));
  append_u32(tag, kTextAt);
  for (const char c : ascii) {
    tag += '\0';
    tag += c;
  }
  return tag;
}

// ICC.1:2010, 10.16, function type 3: ((a x + b)^g) from d, c x below.
std::string transfer() {
  std::string tag = "para";
  append_u32(tag, 0);
  append_u32(tag, 3u << 16);
  for (const double value : {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045}) append_fixed(tag, value);
  return tag;
}

}  // namespace

std::string srgb_icc_profile() {
  const std::string curve = transfer();
  // Lindbloom 2017, "RGB/XYZ Matrices" and "Chromatic Adaptation": sRGB's primaries brought from D65 to the D50 of profiles by
  // Bradford's method, and the matrix that brings them.
  const std::vector<std::pair<std::string_view, std::string>> tags = {
      {"desc", text("sRGB")},
      {"cprt", text("No copyright, use freely")},
      {"wtpt", numbers("XYZ ", {0.9642, 1, 0.8249})},
      {"chad", numbers("sf32", {1.0478112, 0.0228866, -0.0501270, 0.0295424, 0.9904844, -0.0170491,
                                -0.0092345, 0.0150436, 0.7521316})},
      {"rXYZ", numbers("XYZ ", {0.4360747, 0.2225045, 0.0139322})},
      {"gXYZ", numbers("XYZ ", {0.3850649, 0.7168786, 0.0971045})},
      {"bXYZ", numbers("XYZ ", {0.1430804, 0.0606169, 0.7141733})},
      {"rTRC", curve},
      {"gTRC", curve},
      {"bTRC", curve},
  };
  constexpr std::size_t kHeaderBytes = 128, kRowBytes = 12;
  std::string table, data;
  append_u32(table, static_cast<std::uint32_t>(tags.size()));
  const std::size_t data_at = kHeaderBytes + 4 + kRowBytes * tags.size();
  std::size_t curve_at = 0;
  for (const auto& [name, tag] : tags) {
    const bool is_curve = name.ends_with("TRC");
    if (!is_curve || curve_at == 0) {
      if (is_curve) curve_at = data.size();
      table += name;
      append_u32(table, static_cast<std::uint32_t>(data_at + data.size()));
      data += tag;
      data.resize((data.size() + 3) / 4 * 4, '\0');
    } else {
      table += name;
      append_u32(table, static_cast<std::uint32_t>(data_at + curve_at));
    }
    append_u32(table, static_cast<std::uint32_t>(tag.size()));
  }

  std::string profile;
  append_u32(profile, static_cast<std::uint32_t>(data_at + data.size()));
  append_u32(profile, 0);           // preferred module
  append_u32(profile, 0x04300000);  // version 4.3
  profile += "mntrRGB XYZ ";
  profile.append(12, '\0');  // date: none, for the same bytes each time
  profile += "acsp";
  profile.append(28, '\0');  // platform, flags, device, intent: perceptual
  for (const double value : {0.9642, 1.0, 0.8249}) append_fixed(profile, value);  // D50
  profile.resize(kHeaderBytes, '\0');
  return profile + table + data;
}

}  // namespace furnace
