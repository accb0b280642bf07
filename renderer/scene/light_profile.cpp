#include "renderer/scene/light_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/text_number.hpp"

namespace furnace {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

// Numbers after the labels, parted by blanks, commas and line ends as one likes.
class Numbers {
 public:
  Numbers(std::string_view text, int line) : rest_(text), line_(line) {}

  double next(std::string_view what) {
    while (!rest_.empty() && is_gap(rest_.front())) {
      if (rest_.front() == '\n') ++line_;
      rest_.remove_prefix(1);
    }
    const std::size_t length = std::size_t(std::find_if(rest_.begin(), rest_.end(), is_gap) - rest_.begin());
    const std::string_view word = rest_.substr(0, length);
    if (word.empty()) refuse(fmt::format("the file ends before {}", what));
    rest_.remove_prefix(length);
    const std::optional<double> number = number_in(word);
    if (!number || !std::isfinite(*number)) refuse(fmt::format("{} is no number", what));
    return *number;
  }
  int count(std::string_view what, int most) {
    const double number = next(what);
    if (!(number >= 1) || number > most || number != std::floor(number))
      refuse(fmt::format("{} must be a whole number from 1 to {}", what, most));
    return int(number);
  }
  std::vector<double> list(int count, std::string_view what) {
    std::vector<double> numbers;
    for (int i = 0; i < count; ++i) numbers.push_back(next(what));
    return numbers;
  }
  [[noreturn]] void refuse(const std::string& message) const {
    fail(ErrorCode::kUnprocessable, fmt::format("IES profile, line {}: {}", line_, message));
  }

 private:
  static bool is_gap(char c) {
    return c == ' ' || c == ',' || c == '\n' || c == '\r' || c == '\t' || c == '\0' || c == '\x1a';
  }

  std::string_view rest_;
  int line_;
};

bool ascends(const std::vector<double>& angles) {
  return std::adjacent_find(angles.begin(), angles.end(), std::greater_equal<>()) == angles.end();
}

// The label lines end with the one that begins with TILT=; the numbers follow it.
Numbers skip_labels(std::string_view text) {
  int line = 1;
  for (std::string_view rest = text; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view row = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!row.empty() && (row.back() == '\r' || row.back() == ' ')) row.remove_suffix(1);
    if (!row.starts_with("TILT=")) continue;
    Numbers numbers(rest, line + 1);
    const std::string_view tilt = row.substr(5);
    if (tilt == "INCLUDE") {
      numbers.next("the geometry of the tilt");
      const int angles = numbers.count("the count of tilt angles", 1000);
      numbers.list(2 * angles, "a tilt angle or factor");
    } else if (tilt != "NONE") {
      numbers.refuse("a TILT of its own file is not read; write TILT=NONE");
    }
    return numbers;
  }
  fail(ErrorCode::kUnprocessable,
       "IES profile: there is no line that begins with TILT=; is it an LM-63 file?");
}

// What symmetry leaves out: all round from 0 to 360 degrees.
struct Round {
  std::vector<double> degrees;
  std::vector<int> row;  // of the file, for each
};

std::optional<Round> all_round(const std::vector<double>& degrees) {
  Round out;
  const double first = degrees.front(), last = degrees.back();
  const auto add = [&](double angle, std::size_t row) {
    if (!out.degrees.empty() && angle <= out.degrees.back() + 1e-9) return;
    out.degrees.push_back(angle);
    out.row.push_back(int(row));
  };
  const std::size_t count = degrees.size();
  const auto forwards = [&](double offset) {
    for (std::size_t i = 0; i < count; ++i) add(offset + degrees[i], i);
  };
  const auto backwards = [&](double offset) {
    for (std::size_t i = count; i-- > 0;) add(offset - degrees[i], i);
  };
  if (count == 1 && first == 0) {
    forwards(0);
  } else if (first == 0 && last == 90) {
    forwards(0), backwards(180), forwards(180), backwards(360);
  } else if (first == 0 && last == 180) {
    forwards(0), backwards(360);
  } else if (first == 0 && last == 360) {
    forwards(0);
  } else if (first == 90 && last == 270) {  // its mirror plane is the one through 90 and 270 degrees
    for (std::size_t i = count; i-- > 0;)
      if (degrees[i] <= 180) add(180 - degrees[i], i);
    forwards(0);
    for (std::size_t i = count; i-- > 0;)
      if (degrees[i] >= 180) add(540 - degrees[i], i);
  } else {
    return std::nullopt;
  }
  return out;
}

// Integral of I sin(v) dv, I linear between the angles.
double flux_of_plane(const std::vector<double>& vertical, std::span<const double> candela) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < vertical.size(); ++i) {
    const double v0 = vertical[i], v1 = vertical[i + 1];
    const double slope = (candela[i + 1] - candela[i]) / (v1 - v0);
    sum += candela[i] * std::cos(v0) - candela[i + 1] * std::cos(v1) + slope * (std::sin(v1) - std::sin(v0));
  }
  return sum;
}

// Index of the last angle at or below, and how far on to the next.
struct Between {
  std::size_t index = 0;
  double part = 0;
};
Between between(const std::vector<double>& angles, double angle) {
  if (angles.size() < 2) return {};
  const auto above = std::upper_bound(angles.begin() + 1, angles.end() - 1, angle);
  const std::size_t i = std::size_t(above - angles.begin()) - 1;
  return {i, std::clamp((angle - angles[i]) / (angles[i + 1] - angles[i]), 0.0, 1.0)};
}

}  // namespace

double LightProfile::candela_towards(double vertical_rad, double horizontal_rad) const {
  constexpr double kSlack = 1e-6;
  if (vertical_rad < vertical.front() - kSlack || vertical_rad > vertical.back() + kSlack) return 0;
  const Between v = between(vertical, vertical_rad), h = between(horizontal, horizontal_rad);
  const auto along = [&](std::size_t row) {
    const double* values = candela.data() + row * vertical.size();
    return std::lerp(values[v.index], values[v.index + 1], v.part);
  };
  return h.part > 0 ? std::lerp(along(h.index), along(h.index + 1), h.part) : along(h.index);
}

LightProfile parse_ies(std::string_view text, const ProfileLimits& limits) {
  Numbers numbers = skip_labels(text);
  numbers.next("the count of lamps");
  numbers.next("the lumens of a lamp");
  double multiplier = numbers.next("the candela multiplier");
  const int verticals = numbers.count("the count of vertical angles", limits.max_angles);
  const int horizontals = numbers.count("the count of horizontal angles", limits.max_angles / verticals);
  if (numbers.count("the photometric type", 3) != 1)
    numbers.refuse("photometry of type A or B is not read; convert it to type C");
  for (const char* what : {"the type of units", "the width", "the length", "the height"}) numbers.next(what);
  multiplier *= numbers.next("the ballast factor");
  multiplier *= numbers.next("the ballast-lamp factor");
  numbers.next("the watts");
  if (!(multiplier > 0)) numbers.refuse("the candela multiplier and the ballast factors must be above 0");

  const std::vector<double> vertical = numbers.list(verticals, "a vertical angle");
  if (verticals < 2 || !ascends(vertical) || vertical.front() < 0 || vertical.back() > 180)
    numbers.refuse("vertical angles must be two or more, ascend and lie within 0 and 180 degrees");
  const std::vector<double> horizontal = numbers.list(horizontals, "a horizontal angle");
  const std::optional<Round> round = ascends(horizontal) ? all_round(horizontal) : std::nullopt;
  if (!round)
    numbers.refuse("horizontal angles must ascend from 0 to 0, 90, 180 or 360 degrees, or from 90 to 270");
  const std::vector<double> candela = numbers.list(verticals * horizontals, "a candela value");
  if (std::any_of(candela.begin(), candela.end(), [](double value) { return value < 0; }))
    numbers.refuse("a candela value is below 0");

  LightProfile profile;
  profile.hash = HashBuilder().add(text).finish();
  for (const double angle : vertical) profile.vertical.push_back(angle * kDegree);
  for (const double angle : round->degrees) profile.horizontal.push_back(angle * kDegree);
  for (const int row : round->row) {
    for (int i = 0; i < verticals; ++i)
      profile.candela.push_back(candela[std::size_t(row * verticals + i)] * multiplier);
  }
  profile.peak_candela = *std::max_element(profile.candela.begin(), profile.candela.end());
  if (!(profile.peak_candela > 0) || !std::isfinite(profile.peak_candela))
    numbers.refuse("every candela value is 0, or one of them is too large");
  const auto plane = [&](std::size_t row) {
    return flux_of_plane(
        profile.vertical,
        std::span(profile.candela).subspan(row * std::size_t(verticals), std::size_t(verticals)));
  };
  if (profile.horizontal.size() == 1) profile.flux_lumen = 2 * kPi * plane(0);
  for (std::size_t i = 0; i + 1 < profile.horizontal.size(); ++i)
    profile.flux_lumen +=
        (profile.horizontal[i + 1] - profile.horizontal[i]) * 0.5 * (plane(i) + plane(i + 1));
  return profile;
}

}  // namespace furnace
