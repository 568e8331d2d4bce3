/// Random numbers that belong to an event, not to the order in which events are asked for.
///
/// A generator is started from a seed and the numbers that name the event (a time, a camera, a beacon). So the noise of a
/// sighting is the same whichever method asks for it, in whichever order and thread, and two methods can be compared on
/// the same errors. 002 E.2 seeds its generators for the same reason.
/// Generator: SplitMix64 (Steele, Lea, Flood 2014), normal numbers by Box and Muller's transform: the same with every
/// standard library, whose distributions differ.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class KeyedNumbers {
 public:
  /// Numbers of the event named by `keys`; `seed` and every key matter, and so does their order.
  KeyedNumbers(std::uint64_t seed, std::initializer_list<std::int64_t> keys) : state_(mixed(seed)) {
    for (const std::int64_t key : keys) state_ = mixed(state_ ^ mixed(static_cast<std::uint64_t>(key) + increment));
  }

  /// Uniform in [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform among 0 ... count - 1. Precondition: count > 0.
  [[nodiscard]] int below(int count) { return static_cast<int>(uniform() * count); }
  /// Two independent normal numbers of mean 0 and variance 1.
  [[nodiscard]] Vector2 normal_pair() {
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    return Vector2(radius * std::cos(angle), radius * std::sin(angle));
  }

 private:
  static constexpr std::uint64_t increment = 0x9e3779b97f4a7c15u;

  [[nodiscard]] static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  [[nodiscard]] std::uint64_t next() { return mixed(state_ += increment); }

  std::uint64_t state_;
};

}  // namespace holdfast
