/// How far points before a tracked HiBall are taken to be from where they are (002 sections 6.2.2 and E.4).
///
/// Three points, corners of an upright triangle 1 m ahead of the HiBall, along +y of its frame B (hiball_rig.hpp). One
/// number then speaks of position and orientation together, as virtual things do that are seen there. 002 does not give
/// the triangle's size: here its base is 0.5 m and its height 0.45 m, with the middle at the HiBall's height.
///   error vectors   X_WBestimate p_B - X_WB p_B of each point, in W, m
///   RMS, peak       over all points of all estimates ("overall")
///   per estimate    RMS over one estimate's three points, what `add` answers
///   cost            mean over estimates of the mean distance: what 002 tunes filters by (E.4)
/// Bad input: poses that are not finite give figures that are not finite.
#pragma once

#include <array>
#include <cmath>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

inline const std::array<Vector3, 3> three_points_B{Vector3(-0.25, 1.0, -0.15), Vector3(0.25, 1.0, -0.15),
                                                   Vector3(0.0, 1.0, 0.3)};

/// The three error vectors of an estimate, one a column.
[[nodiscard]] inline Matrix3 three_point_errors(const Rigid& X_WB_estimate, const Rigid& X_WB) {
  Matrix3 errors;
  for (int k = 0; k < 3; ++k) {
    const Vector3& p_B = three_points_B[static_cast<std::size_t>(k)];
    errors.col(k) = X_WB_estimate * p_B - X_WB * p_B;
  }
  return errors;
}

/// RMS and peak of lengths.
class RmsAndPeak {
 public:
  void add(double length) {
    sum_ += length * length;
    peak_ = length <= peak_ ? peak_ : length;  // what is not finite stays
    ++count_;
  }
  [[nodiscard]] double rms() const { return count_ > 0 ? std::sqrt(sum_ / static_cast<double>(count_)) : 0.0; }
  [[nodiscard]] double peak() const { return peak_; }
  [[nodiscard]] long count() const { return count_; }

 private:
  double sum_ = 0.0, peak_ = 0.0;
  long count_ = 0;
};

class ThreePointError {
 public:
  /// Takes an estimate; answers its own RMS, m.
  double add(const Rigid& X_WB_estimate, const Rigid& X_WB) {
    const Matrix3 errors = three_point_errors(X_WB_estimate, X_WB);
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      lengths_.add(errors.col(k).norm());
      sum += errors.col(k).norm();
    }
    cost_ += sum / 3.0;
    return errors.norm() / std::sqrt(3.0);
  }

  [[nodiscard]] long estimates() const { return lengths_.count() / 3; }
  [[nodiscard]] double rms() const { return lengths_.rms(); }
  [[nodiscard]] double peak() const { return lengths_.peak(); }
  [[nodiscard]] double cost() const { return estimates() > 0 ? cost_ / static_cast<double>(estimates()) : 0.0; }

 private:
  RmsAndPeak lengths_;
  double cost_ = 0.0;
};

}  // namespace holdfast
