/// The HiBall's ceiling: panels of 32 light-emitting diodes that shine downward (HiBall paper 4.2; 002 D.1).
///
/// A panel is a tile of a standard false ceiling, 24 inches (61 cm) square, with four strips of eight LEDs. Over the whole
/// ceiling that makes a rectangular pattern with periods of 3 and 6 inches (7.6 and 15.2 cm).
/// Frame L, the ceiling's: origin in the ceiling's middle, x along the strips, y across them, z up, away from the room.
/// X_WL places it in any world: the tracker knows no "up". By default W is that of 002: z up, its origin on the floor
/// below a corner of 9 x 14 panels, in whose middle, (2.74, 4.27), 002's still HiBall stands (E.1); the LEDs are at 2.75 m.
/// Size: the paper's 5.5 x 8.5 m are 9 x 14 panels, less a storage room in one corner; about 3,000 LEDs, which are 94
/// panels, leave 4 x 8 panels to that room (`l_shaped`). The default is the plain rectangle of about as many LEDs:
/// 8 x 12 panels, 3,072 LEDs, 4.9 x 7.3 m. 002's "approximately 5x5 meters" with "over 3,000 LEDs" would take denser
/// panels.
/// Beacons are numbered panel by panel, so that beacon / 32 is its panel. Bad input: `problem` names it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

struct CeilingLayout {
  int columns = 8;      ///< panels along x of L
  int rows = 12;        ///< panels along y of L
  int cut_columns = 0;  ///< of the corner at greatest x and y, which has no panels
  int cut_rows = 0;
  Rigid X_WL = Rigid::translation(Vector3(2.74, 4.27, 2.75));

  static constexpr double panel_m = 0.6096;
  static constexpr int leds_along = 8;  ///< of a strip, along x
  static constexpr int strips = 4;      ///< of a panel, along y
  static constexpr int panel_leds = leds_along * strips;
  static constexpr double period_x_m = panel_m / leds_along;
  static constexpr double period_y_m = panel_m / strips;

  /// As built: 5.5 x 8.5 m with a corner cut out, 94 panels, 3,008 LEDs.
  [[nodiscard]] static CeilingLayout l_shaped() {
    CeilingLayout layout;
    layout.columns = 9, layout.rows = 14, layout.cut_columns = 4, layout.cut_rows = 8;
    return layout;
  }

  /// What is wrong with it; nothing when it can be used.
  [[nodiscard]] std::optional<std::string_view> problem() const {
    if (columns < 1 || rows < 1 || columns > 1000 || rows > 1000) return "a ceiling has 1 to 1000 panels each way";
    if (cut_columns < 0 || cut_rows < 0) return "the corner that is cut out has a negative size";
    if (panels() < 1) return "the corner that is cut out leaves no panel";
    if (!X_WL.is_finite()) return "the ceiling's pose is not finite";
    return std::nullopt;
  }

  [[nodiscard]] int panels() const { return columns * rows - cut_columns * cut_rows; }
  [[nodiscard]] int beacons() const { return panels() * panel_leds; }
  [[nodiscard]] double width_m() const { return columns * panel_m; }  ///< along x
  [[nodiscard]] double depth_m() const { return rows * panel_m; }     ///< along y

  /// The panel in this column and row; -1 where there is none.
  [[nodiscard]] int panel_at(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns || row >= rows) return -1;
    const int whole_rows = rows - cut_rows;
    if (row < whole_rows) return row * columns + column;
    const int short_row = columns - cut_columns;
    if (column >= short_row) return -1;
    return whole_rows * columns + (row - whole_rows) * short_row + column;
  }

  /// The beacon in place (i, j) of the pattern, 0 <= i < 8 columns, 0 <= j < 4 rows; -1 where there is none.
  [[nodiscard]] int beacon_at(int i, int j) const {
    if (i < 0 || j < 0) return -1;
    const int panel = panel_at(i / leds_along, j / strips);
    return panel < 0 ? -1 : panel * panel_leds + (j % strips) * leds_along + i % leds_along;
  }

  /// Place (i, j) of the pattern in L, on the ceiling's plane.
  [[nodiscard]] Vector3 place_L(int i, int j) const {
    return Vector3((i + 0.5) * period_x_m - 0.5 * width_m(), (j + 0.5) * period_y_m - 0.5 * depth_m(), 0.0);
  }

  /// Where design puts the beacons, in W.
  [[nodiscard]] std::vector<Vector3> places_W() const {
    std::vector<Vector3> places(static_cast<std::size_t>(beacons()));
    for (int j = 0; j < rows * strips; ++j) {
      for (int i = 0; i < columns * leds_along; ++i) {
        const int beacon = beacon_at(i, j);
        if (beacon >= 0) places[static_cast<std::size_t>(beacon)] = X_WL * place_L(i, j);
      }
    }
    return places;
  }

  /// The direction in which beacons shine, in W.
  [[nodiscard]] Vector3 beacon_axis_W() const { return X_WL.q() * Vector3(-Vector3::UnitZ()); }
};

/// A ceiling's pose from its middle and the way up, of any length but zero.
[[nodiscard]] inline Rigid ceiling_pose(const Vector3& middle_W, const Vector3& up_W) {
  return Rigid(so3::between<double>(Vector3::UnitZ(), up_W), middle_W);
}

}  // namespace holdfast
