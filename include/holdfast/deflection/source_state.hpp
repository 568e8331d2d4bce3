/// What a warp found for one pixel: whether the source picture holds what is to be seen there.
#pragma once

#include <cstdint>
#include <string_view>

namespace holdfast {

enum class SourceState : std::uint8_t {
  covered,      ///< the source picture shows it
  disoccluded,  ///< it was hidden when the picture was drawn, and a depth deflection reveals it; its colour is a guess
  outside,      ///< it lies beyond the source picture's edges
  not_seen,     ///< no source direction at all: outside the lens's domain or the panel, or not ahead of the source eye
};

[[nodiscard]] constexpr std::string_view name_of(SourceState state) {
  constexpr std::string_view names[] = {"covered", "disoccluded", "outside", "not_seen"};
  return names[static_cast<std::size_t>(state)];
}

}  // namespace holdfast
