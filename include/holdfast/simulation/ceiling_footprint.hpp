/// Which part of the ceiling a camera's field can reach: the few beacons worth testing, out of thousands.
///
/// The field is a pyramid over the photodiode. Its section with the ceiling is a polygon, and the rectangle round that
/// names a block of the LED pattern (HiBall paper 5.3 projects the photodiode's four corners likewise). It is
/// conservative: beacons may lie anywhere within `reach_m` of their design along each axis of L. Fields that look partly
/// below the horizon are cut there first.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <holdfast/simulation/hiball_rig.hpp>

namespace holdfast {

/// Places i_begin <= i < i_end, j_begin <= j < j_end of the LED pattern.
struct CeilingCells {
  int i_begin = 0, i_end = 0, j_begin = 0, j_end = 0;

  [[nodiscard]] bool empty() const { return i_begin >= i_end || j_begin >= j_end; }
};

namespace detail {

/// Grows round directions of L that end on the two planes between which beacons hang.
class FootprintBox {
 public:
  FootprintBox(double lowest_m, double highest_m) : heights_{lowest_m, highest_m} {}

  void add(const Vector3& direction_L) {
    for (const double height : heights_) {
      const Vector2 place = (height / direction_L.z()) * direction_L.head<2>();
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
  }
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity());
  Vector2 high = -low;

 private:
  std::array<double, 2> heights_;
};

/// Those of 0 <= index < count whose place (index + 0.5) period lies in [low, high].
inline void index_range(double low, double high, double period, int count, int& begin, int& end) {
  begin = static_cast<int>(std::clamp(std::ceil(low / period - 0.5), 0.0, static_cast<double>(count)));
  end = static_cast<int>(std::clamp(std::floor(high / period - 0.5) + 1.0, 0.0, static_cast<double>(count)));
}

}  // namespace detail

/// Precondition: X_LB finite.
[[nodiscard]] inline CeilingCells ceiling_footprint(const CeilingLayout& layout, const HiBallCamera& camera,
                                                    const Rigid& X_LB, double reach_m) {
  const int i_count = layout.columns * CeilingLayout::leds_along, j_count = layout.rows * CeilingLayout::strips;
  const CeilingCells all{0, i_count, 0, j_count};
  const Vector3 centre_L = X_LB * camera.centre_B;
  const double lowest = -reach_m - centre_L.z(), highest = reach_m - centre_L.z();
  if (highest <= 0.0) return {};  // above the beacons, which shine downward
  if (lowest < 0.01) return all;  // among them
  const Matrix3 R_LB = X_LB.R();
  std::array<Vector3, 4> corners_L;
  for (std::size_t k = 0; k < 4; ++k) corners_L[k] = R_LB * camera.corners_B[k].normalized();

  constexpr double horizon = 1e-6;  // the ceiling there is 10 km away
  detail::FootprintBox box(lowest, highest);
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3 &a = corners_L[k], &b = corners_L[(k + 1) % 4];
    if (a.z() >= horizon) box.add(a);
    if ((a.z() >= horizon) != (b.z() >= horizon)) {
      const double s = (horizon - a.z()) / (b.z() - a.z());
      Vector3 cut = a + s * (b - a);
      cut.z() = horizon;
      box.add(cut);
    }
  }
  const Vector2 corner_L(-0.5 * layout.width_m(), -0.5 * layout.depth_m());
  const Vector2 from = centre_L.head<2>() - corner_L - Vector2::Constant(reach_m);
  const Vector2 to = centre_L.head<2>() - corner_L + Vector2::Constant(reach_m);
  CeilingCells cells;
  detail::index_range(from.x() + box.low.x(), to.x() + box.high.x(), CeilingLayout::period_x_m, i_count, cells.i_begin,
                      cells.i_end);
  detail::index_range(from.y() + box.low.y(), to.y() + box.high.y(), CeilingLayout::period_y_m, j_count, cells.j_begin,
                      cells.j_end);
  return cells;
}

}  // namespace holdfast
