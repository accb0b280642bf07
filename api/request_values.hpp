// What the readers of a request share: faults that are told together, and values that keep their default.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "api/document.hpp"
#include "api/problem.hpp"
#include "renderer/scene/transform.hpp"
#include "renderer/base/check.hpp"

namespace furnace::api {

// Faults found after the schema was satisfied; they are told together.
class Faults {
 public:
  bool full() const { return problems_.size() >= kMaxProblems; }

  void add(ErrorCode code, const Value& place, std::string message) {
    if (full()) return;
    mixed_ = mixed_ || (!problems_.empty() && code != code_);
    code_ = code;
    problems_.push_back({place.pointer(), std::move(message)});
  }

  // Runs `step`; an Error becomes a fault at `place`. A pointer that is not the place's leads into the file
  // named there.
  void collect(const Value& place, const std::function<void()>& step) {
    try {
      step();
    } catch (const Error& error) {
      const bool inside = !error.pointer.empty() && error.pointer != place.pointer();
      add(error.code, place,
          inside ? fmt::format("{} of the file: {}", error.pointer, error.message) : error.message);
      details_ += error.detail;
    }
  }

  void throw_if_any() {
    try {
      fail_if_any(std::move(problems_), mixed_ ? ErrorCode::kUnprocessable : code_);
    } catch (Error& error) {
      error.detail = details_;
      throw;
    }
  }

 private:
  std::vector<Problem> problems_;
  std::string details_;
  ErrorCode code_ = ErrorCode::kUnprocessable;
  bool mixed_ = false;
};

// An absent value leaves the target at its default.
inline void read(const Value& value, bool& target) {
  if (value) target = value.boolean();
}

inline void read(const Value& value, int& target) {
  if (value) target = value.integer();
}

inline void read(const Value& value, float& target) {
  if (value) target = static_cast<float>(value.number());
}

inline void read(const Value& value, double& target) {
  if (value) target = value.number();
}

inline void read(const Value& value, glm::vec2& target) {
  if (value) target = {value.at(0).number(), value.at(1).number()};
}

inline void read(const Value& value, glm::vec3& target) {
  if (value) target = {value.at(0).number(), value.at(1).number(), value.at(2).number()};
}

inline void read(const Value& value, glm::dvec3& target) {
  if (value) target = {value.at(0).number(), value.at(1).number(), value.at(2).number()};
}

// Three numbers or four; without the fourth alpha is 1.
inline void read(const Value& value, glm::vec4& target) {
  if (value)
    target = {value.at(0).number(), value.at(1).number(), value.at(2).number(),
              value.size() > 3 ? value.at(3).number() : 1.0};
}

inline void read(const Value& value, std::string& target) {
  if (value) target = value.text();
}

template <class T>
void read(const Value& value, std::optional<T>& target) {
  if (value) read(value, target.emplace());
}

inline void read_degrees(const Value& value, double& target_rad) {
  if (value) target_rad = radians_from_degrees(value.number());
}

template <class T>
struct Choice {
  std::string_view name;
  T value;
};

// The schema lists the same names, so one of them fits.
template <class T, std::size_t kCount>
void read_choice(const Value& value, const Choice<T> (&choices)[kCount], T& target) {
  if (!value) return;
  const auto* found = std::find_if(choices, choices + kCount,
                                   [&](const Choice<T>& choice) { return choice.name == value.text(); });
  FURNACE_CHECK(found != choices + kCount, "{} is not handled", value.text());
  target = found->value;
}

// x, y, z, w of any length but none.
inline glm::quat read_rotation(const Value& value, Faults& faults) {
  const glm::dvec4 xyzw(value.at(0).number(), value.at(1).number(), value.at(2).number(),
                        value.at(3).number());
  constexpr double kShortest = 1e-3;  // below, rounded decimals leave no direction
  const double length = glm::length(xyzw);
  if (length < kShortest) {
    faults.add(ErrorCode::kUnprocessable, value, "has no length; no rotation is [0, 0, 0, 1]");
    return {1, 0, 0, 0};
  }
  const glm::vec4 unit(xyzw / length);
  return {unit.w, unit.x, unit.y, unit.z};
}

}  // namespace furnace::api
