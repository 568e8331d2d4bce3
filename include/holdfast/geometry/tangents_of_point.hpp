/// Tangents of field angle: where an eye sees a point, and the direction of what it sees.
///
/// An eye E looks along -Z (+X right, +Y up). The tangents of a point are (x / -z, y / -z): right and up positive, no
/// unit. Bad input: a point at or behind the eye's plane, or that is not finite, has none.
#pragma once

#include <optional>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

/// Tangents of a point or direction in an eye's frame; nothing when it is not ahead of the eye (z >= 0).
[[nodiscard]] inline std::optional<Vector2> tangents_of_point(const Vector3& p_E) {
  if (!(p_E.z() < 0.0) || !p_E.allFinite()) return std::nullopt;
  return Vector2(p_E.x() / -p_E.z(), p_E.y() / -p_E.z());
}

/// Direction (not unit) of tangents t: (t_x, t_y, -1).
[[nodiscard]] inline Vector3 direction_of_tangents(const Vector2& t) {
  return {t.x(), t.y(), -1.0};
}

}  // namespace holdfast
