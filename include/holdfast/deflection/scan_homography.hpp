/// A projective map that changes from line to line of a display's scan: quadratic in the line fraction.
///
/// (t_S, 1) ~ H_SE(s) (t_E, 1): the tangent t_E at which the displayed eye looks, at line fraction s, is found in the
/// source picture at t_S. Three maps fix it, at the scan's begin (s = 0), middle (1/2) and end (1):
///
///     H_SE(s) = B + s (L + s Q),    L = 4 (M - B) - (E - B),    Q = 2 (E - B) - 4 (M - B).
///
/// Where begin, middle and end are equal, L and Q are zero to the last bit. The interpolation's error is that of a
/// parabola through three points, |s (s - 1/2) (s - 1)| |H'''| / 6 <= 0.0080 |H'''|: for a turn by a (rad) during the
/// scan H''' = a^3, so 200 deg/s during 11.1 ms leave 4.7e-7 of tangent, under 0.001 px of a headset's picture.
/// Between the samples the sizes of the three matrices matter: make them from one formula, smooth in s.
/// Bad input: nothing is checked; maps come from deflect(), which does.
#pragma once

#include <optional>

#include <holdfast/geometry/homography.hpp>

namespace holdfast {

/// Three matrices through which one of a line fraction runs, as a parabola per element.
struct ScanMatrices {
  Matrix3 begin = Matrix3::Identity();
  Matrix3 middle = Matrix3::Identity();
  Matrix3 end = Matrix3::Identity();

  /// L and Q above: what a shader multiplies by s and s^2.
  [[nodiscard]] Matrix3 linear() const { return 4.0 * (middle - begin) - (end - begin); }
  [[nodiscard]] Matrix3 quadratic() const { return 2.0 * (end - begin) - 4.0 * (middle - begin); }
  [[nodiscard]] Matrix3 at(double s) const { return begin + s * (linear() + s * quadratic()); }

  [[nodiscard]] bool is_constant() const { return begin == middle && middle == end; }
  /// Whether it is the identity at every line, to the last bit.
  [[nodiscard]] bool is_identity() const { return is_constant() && begin == Matrix3::Identity(); }

  friend bool operator==(const ScanMatrices&, const ScanMatrices&) = default;
};

class ScanHomography {
 public:
  /// The identity: the source picture is shown as it is.
  ScanHomography() = default;

  /// The same map for all lines.
  explicit ScanHomography(const Homography& H_SE) : ScanHomography(H_SE, H_SE, H_SE) {}
  ScanHomography(const Homography& begin_SE, const Homography& middle_SE, const Homography& end_SE)
      : ScanHomography(ScanMatrices{begin_SE.matrix(), middle_SE.matrix(), end_SE.matrix()}) {}
  explicit ScanHomography(const ScanMatrices& H_SE) : H_(H_SE), linear_(H_SE.linear()), quadratic_(H_SE.quadratic()) {}

  [[nodiscard]] const ScanMatrices& matrices() const { return H_; }
  [[nodiscard]] const Matrix3& begin() const { return H_.begin; }
  [[nodiscard]] const Matrix3& middle() const { return H_.middle; }
  [[nodiscard]] const Matrix3& end() const { return H_.end; }
  [[nodiscard]] bool is_constant() const { return H_.is_constant(); }

  /// The matrix of one line; it keeps its sign (a positive third component is a direction ahead of S).
  [[nodiscard]] Matrix3 at(double s) const { return H_.begin + s * (linear_ + s * quadratic_); }

  /// t_S of t_E; nothing when the direction is not ahead of the source eye.
  [[nodiscard]] std::optional<Vector2> source_tangent(const Vector2& t_E, double s) const {
    return applied(at(s), t_E);
  }
  /// t_E of t_S: its inverse at one line.
  [[nodiscard]] std::optional<Vector2> displayed_tangent(const Vector2& t_S, double s) const {
    const Matrix3 H_ES = at(s).inverse();
    return applied(H_ES, t_S);
  }

 private:
  [[nodiscard]] static std::optional<Vector2> applied(const Matrix3& H, const Vector2& t) {
    const Vector3 h = H * Vector3(t.x(), t.y(), 1.0);
    if (!(h.z() > 0.0)) return std::nullopt;
    return Vector2(h.x() / h.z(), h.y() / h.z());
  }

  ScanMatrices H_;
  Matrix3 linear_ = Matrix3::Zero();
  Matrix3 quadratic_ = Matrix3::Zero();
};

}  // namespace holdfast
