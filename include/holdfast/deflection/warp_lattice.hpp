/// A lens made ready for warping on the CPU: which ideal tangent each panel pixel shows, per colour, compactly.
///
/// Prepared once an eye (a few milliseconds); it depends on eye and LensMode alone, not on poses. Most of the panel is
/// covered by bicubic polynomials over cells of 32x32 pixels, fitted to the exact lens; where those would be wrong by
/// more than max_error_px, and where the lens's domain ends, exact values are kept for every pixel. max_error_px is
/// counted in panel pixels at the panel's paraxial density; max_error_px() is the greatest that was found at 81 pixels
/// of each cell. Without a lens there is nothing to keep (is_linear). Precondition: the eye's fields are sound (io's
/// reader sees to it); an eye without pixels gives an empty lattice, which the warp refuses.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include <holdfast/deflection/detail/lens_cells.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/lens.hpp>

namespace holdfast {

class WarpLattice {
 public:
  static constexpr double default_max_error_px = 0.002;  ///< half a step of 255 at the steepest edge there can be

  WarpLattice(const EyeModel& eye, LensMode mode, double max_error_px = default_max_error_px)
      : mode_(mode), size_(eye.resolution), panel_(panel_tangents(eye)), probes_(probes_of(eye, mode)) {
    if (mode == LensMode::none || mode == LensMode::uncorrected || size_.width <= 0 || size_.height <= 0) return;
    per_color_ = eye.lens_red.has_value() || eye.lens_blue.has_value();
    bool bends = false;
    for (const Color color : {Color::red, Color::green, Color::blue}) {
      if (!per_color_ && color != Color::green) continue;
      const auto ideal_at = [&eye, mode, color](const Vector2& pixel) {
        return ideal_tangent_at_panel(eye.lens_of(color), mode, tangent_of_pixel(eye, pixel));
      };
      detail::LensCells& cells = cells_[static_cast<std::size_t>(color)];
      cells = detail::LensCellsBuilder(eye, ideal_at, max_error_px).build();
      bends = bends || cells.max_change_px > 1e-9;
      max_error_px_ = std::max(max_error_px_, cells.max_error_px);
    }
    if (bends) return;
    cells_ = {};
    per_color_ = false;
  }

  [[nodiscard]] LensMode mode() const { return mode_; }
  [[nodiscard]] PixelSize size() const { return size_; }
  /// Whether it was prepared for this panel, mode and lens. Lenses are told apart by what a few places of the panel
  /// show in each colour.
  [[nodiscard]] bool is_for(const EyeModel& eye, LensMode mode) const {
    return mode == mode_ && eye.resolution == size_ && panel_tangents(eye) == panel_ &&
           std::equal(probes_.begin(), probes_.end(), probes_of(eye, mode).begin(), is_same);
  }
  /// Whether the colours are bent differently: three positions a pixel.
  [[nodiscard]] bool per_color() const { return per_color_; }
  /// Whether every panel pixel shows its own tangent.
  [[nodiscard]] bool is_linear() const { return cells_[1].cells.empty(); }
  /// Greatest error of the polynomials, panel px.
  [[nodiscard]] double max_error_px() const { return max_error_px_; }
  /// Memory of all colours, bytes.
  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& c : cells_) sum += c.numbers.size() * sizeof(float) + c.cells.size() * sizeof(detail::LensCell);
    return sum;
  }
  /// Cells of a colour; those of green stand for all when per_color() is false. Precondition: not linear.
  [[nodiscard]] const detail::LensCells& cells(Color color) const {
    return cells_[static_cast<std::size_t>(per_color_ ? color : Color::green)];
  }

 private:
  /// Places at various distances from any centre, three colours each.
  using Probes = std::array<std::optional<Vector2>, 18>;

  [[nodiscard]] static Probes probes_of(const EyeModel& eye, LensMode mode) {
    constexpr double places[][2] = {{0.5, 0.5}, {0.31, 0.62}, {0.83, 0.44}, {0.55, 0.11}, {0.13, 0.94}, {0.97, 0.05}};
    const FieldTangents t = panel_tangents(eye);
    Probes probes;
    std::size_t i = 0;
    for (const auto& [u, v] : places) {
      const Vector2 panel(t.left + u * (t.right - t.left), t.down + v * (t.up - t.down));
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        probes[i++] = ideal_tangent_at_panel(eye.lens_of(color), mode, panel);
      }
    }
    return probes;
  }
  /// To rounding.
  [[nodiscard]] static bool is_same(const std::optional<Vector2>& a, const std::optional<Vector2>& b) {
    return a.has_value() == b.has_value() && (!a || (*a - *b).norm() <= 1e-12 * (1.0 + a->norm()));
  }

  LensMode mode_;
  PixelSize size_;
  FieldTangents panel_;
  Probes probes_;
  bool per_color_ = false;
  double max_error_px_ = 0.0;
  std::array<detail::LensCells, 3> cells_;
};

}  // namespace holdfast
