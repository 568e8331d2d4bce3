/// On which scan line of a rolling display does a thing light, and where?
///
/// Where a thing is shown decides its line, and the line where it is shown: with place(s) where it would be shown if the
/// line of fraction s lit it, and line(place) the line that lights there, s is a root of line(place(s)) - s. The slope of
/// that is -1, but for the part of the picture's height that the thing moves during the scan, usually below a tenth; so
/// secants find the root in a few steps. Near a lens's edge a thing may be shown for some lines only: where the middle
/// line shows nothing the search starts again from the first, the last and others, at most an eighth of the scan apart,
/// and a step beyond what is shown is halved. s is found to 1e-13, or to 1e-7 where place(s) goes in steps (as one that
/// knows time to the nanosecond).
/// Bad input: nothing when it lights on no line, moves by about the picture's height during the scan (at the very fold of
/// a lens everything does), or grazes the lens's edge within an eighth of the lines.
#pragma once

#include <cmath>
#include <optional>
#include <utility>

namespace holdfast {

/// Where a thing is shown, and the line fraction that lights there.
template <typename Place>
struct LitPlace {
  Place place;
  double line;
};

namespace deflection_detail {

/// The search from one line. `at(s)` is an optional LitPlace.
template <typename At>
[[nodiscard]] auto lit_from(double s, const At& at) -> decltype(at(s)) {
  constexpr double exact = 1e-13, in_steps = 1e-7;
  auto found = at(s);
  if (!found) return std::nullopt;
  double off = found->line - s, slope = -1.0;
  for (int i = 0; i < 30; ++i) {
    if (std::abs(off) <= exact) return found;
    if (!(slope < -0.1) || !(std::abs(s) < 1e6)) return std::nullopt;
    double next_s = s - off / slope;
    auto next = at(next_s);
    for (int halved = 0; !next && halved < 10; ++halved) {
      next_s = 0.5 * (s + next_s);
      next = at(next_s);
    }
    if (!next) return std::nullopt;
    const double next_off = next->line - next_s;
    // Nearer steps tell the slope of rounding.
    if (std::abs(next_s - s) > 1e-6) slope = (next_off - off) / (next_s - s);
    s = next_s;
    off = next_off;
    found = std::move(next);
  }
  return std::abs(off) <= in_steps ? found : std::nullopt;
}

}  // namespace deflection_detail

/// The place at which a thing lights. `at(s)` is an optional LitPlace: where it is shown if line s lights it, and the
/// line there.
template <typename At>
[[nodiscard]] auto on_its_line(const At& at) -> std::optional<decltype(at(0.5)->place)> {
  for (const double start : {0.5, 0.0, 1.0, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875}) {
    if (auto found = deflection_detail::lit_from(start, at)) return std::move(found->place);
  }
  return std::nullopt;
}

}  // namespace holdfast
