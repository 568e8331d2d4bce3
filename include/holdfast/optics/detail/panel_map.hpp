/// What an eye's panel shows, for many points at once: the ideal tangent of each colour, or that there is none.
///
/// The same answers as ideal_tangent_at_panel, but the lens's model is looked up once for a batch of points, and the
/// domain ends a little earlier: where the lens all but folds (predistortion_mesh.hpp), and at the border of a field.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>
#include <variant>

#include <holdfast/optics/catmull_rom_lens.hpp>
#include <holdfast/optics/detail/radial_bend.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/point_mesh_lens.hpp>

namespace holdfast::detail {

/// One panel point: its ideal tangents (red, green, blue; of one colour alone when all are alike), and whether all of
/// them exist.
struct PanelLook {
  std::array<Vector2, 3> ideal;
  bool inside = true;
};

class PanelMap {
 public:
  PanelMap(const EyeModel& eye, LensMode mode, const std::optional<FieldTangents>& field)
      : inverse_(mode == LensMode::cubic), identity_(mode == LensMode::none || mode == LensMode::uncorrected) {
    colours_ = !identity_ && (eye.lens_red || eye.lens_blue) ? 3 : 1;
    for (int c = 0; c < colours_; ++c) {
      const Lens& lens = eye.lens_of(colours_ == 3 ? static_cast<Color>(c) : Color::green);
      lenses_[static_cast<std::size_t>(c)] = inverse_ ? lens.cubic_inverse() : lens;
      has_end_ =
          has_end_ || (!identity_ && std::isfinite(lenses_[static_cast<std::size_t>(c)].valid_radius())) || inverse_;
      smooth_ =
          smooth_ && (identity_ || inverse_ || !(lens.model_if<PointMeshLens>() || lens.model_if<CatmullRomLens>()));
      radial_ = radial_ && !inverse_ && (detail::is_radial(lens) || lens.model_if<NoLens>());
      const double end = end_radius(lens);
      end_radius2_[static_cast<std::size_t>(c)] = end * end;
    }
    if (colours_ == 1) identity_ = identity_ || lenses_[0].model_if<NoLens>() != nullptr;
    if (!field) return;
    const auto [left, right] = std::minmax({field->left, field->right});
    const auto [down, up] = std::minmax({field->down, field->up});
    field_ = FieldTangents{left, right, down, up};
  }

  [[nodiscard]] int colours() const { return colours_; }
  /// No kinks: neither samples nor Oculus's spline, whose derivative jumps at its next to last knot.
  [[nodiscard]] bool is_smooth() const { return smooth_; }
  /// Whether the triangle of panel tangents a b c may hold a kink of some colour's lens.
  [[nodiscard]] bool may_kink(const Vector2& a, const Vector2& b, const Vector2& c) const {
    if (smooth_) return false;
    for (std::size_t i = 0; i < static_cast<std::size_t>(colours_); ++i) {
      const CatmullRomLens* spline = lenses_[i].model_if<CatmullRomLens>();
      if (spline == nullptr && lenses_[i].model_if<PointMeshLens>() == nullptr) continue;
      if (spline == nullptr) return true;
      const LensPlacement& place = lenses_[i].placement();
      const auto radius = [&](const Vector2& p) { return (p - place.centre).cwiseQuotient(place.scale).norm(); };
      const double kink = std::sqrt(0.9) * spline->coefficients().r_max;  // x = 9
      const double ra = radius(a), rb = radius(b), rc = radius(c);
      if (std::max({ra, rb, rc}) < kink) continue;                     // the disc is convex
      const double reach = (b - a).cwiseQuotient(place.scale).norm();  // a b is the longest edge
      if (std::max({ra, rb, rc}) - reach > kink) continue;
      return true;
    }
    return false;
  }
  /// A few points tell how the lens bends between them, and no border is expected but perhaps that of its domain.
  [[nodiscard]] bool is_simple() const { return smooth_ && !inverse_ && !field_ && !identity_; }
  /// All lenses are radial, and looked through as they are: RadialBend knows them.
  [[nodiscard]] bool is_radial() const { return radial_ && !identity_; }
  [[nodiscard]] std::span<const Lens> lenses() const {
    return std::span(lenses_).first(static_cast<std::size_t>(colours_));
  }
  [[nodiscard]] bool has_field() const { return field_.has_value(); }
  /// Every panel point shows its own tangent.
  [[nodiscard]] bool is_identity() const { return identity_; }
  /// Some of the panel may show nothing.
  [[nodiscard]] bool has_end() const { return field_.has_value() || has_end_; }

  /// Looks of the panel tangents, in the same order.
  void look(std::span<const Vector2> panel, PanelLook* out) const {
    for (std::size_t i = 0; i < panel.size(); ++i) out[i].inside = true;
    if (identity_) {
      for (std::size_t i = 0; i < panel.size(); ++i) out[i].ideal[0] = panel[i];
    } else {
      for (std::size_t c = 0; c < static_cast<std::size_t>(colours_); ++c) {
        std::visit([&](const auto& model) { look_through(model, c, panel, out); }, lenses_[c].model());
      }
    }
    if (field_) cut_to_field(panel.size(), out);
  }

  [[nodiscard]] PanelLook look(const Vector2& panel) const {
    PanelLook one;
    look(std::span(&panel, 1), &one);
    return one;
  }

  /// Whether something is shown there: look(panel).inside.
  [[nodiscard]] bool shows(const Vector2& panel) const {
    if (!is_radial() || field_) return look(panel).inside;
    for (std::size_t c = 0; c < static_cast<std::size_t>(colours_); ++c) {
      const LensPlacement& place = lenses_[c].placement();
      const Vector2 u = (panel - place.centre).cwiseProduct(place.scale.cwiseInverse());
      if (!(u.squaredNorm() <= end_radius2_[c])) return false;
    }
    return true;
  }

 private:
  /// Something is seen less than 1/32 as large as it is; of the cubic, drawn less than 1/8 as large. (The smallest
  /// singular value is between det / |J| and sqrt(2) times that.)
  [[nodiscard]] bool all_but_folds(const Matrix2& J) const {
    return !(J.determinant() >= (inverse_ ? 1.0 / 8.0 : 1.0 / 32.0) * J.norm());
  }

  /// So many points are looked at together, for the sake of vector code.
  static constexpr std::size_t together = 16;

  template <typename Model>
  void look_through(const Model& model, std::size_t c, std::span<const Vector2> panel, PanelLook* out) const {
    if constexpr (RadiallySymmetric<Model>) {
      if (!inverse_) {
        for (; panel.size() >= together; panel = panel.subspan(together), out += together) {
          look_radially<together>(model.profile(), c, panel.data(), out);
        }
        for (std::size_t i = 0; i < panel.size(); ++i) look_radially<1>(model.profile(), c, &panel[i], &out[i]);
        return;
      }
    }
    const Vector2 centre = lenses_[c].placement().centre;
    const Vector2 scale = lenses_[c].placement().scale;
    const Vector2 per_scale = scale.cwiseInverse();
    const double safe = 0.5 * model.valid_radius();  // far from any fold
    for (std::size_t i = 0; i < panel.size(); ++i) {
      const Vector2 u = (panel[i] - centre).cwiseProduct(per_scale);
      if constexpr (std::is_same_v<Model, NoLens>) {
        out[i].ideal[c] = panel[i];
        continue;
      }
      const std::optional<Vector2> v = inverse_ ? model.undistort(u) : model.distort(u);
      const Vector2& on_panel_side = inverse_ && v ? *v : u;  // where the model's Jacobian is asked for
      if (!v || (on_panel_side.squaredNorm() > safe * safe && all_but_folds(model.distort_jacobian(on_panel_side)))) {
        out[i].inside = false;
        continue;
      }
      out[i].ideal[c] = centre + scale.cwiseProduct(*v);
    }
  }

  template <std::size_t N, typename Profile>
  void look_radially(const Profile& profile, std::size_t c, const Vector2* panel, PanelLook* out) const {
    const Vector2 centre = lenses_[c].placement().centre;
    const Vector2 scale = lenses_[c].placement().scale;
    const Vector2 per_scale = scale.cwiseInverse();
    std::array<Vector2, N> u;
    std::array<double, N> s;
    for (std::size_t i = 0; i < N; ++i) u[i] = (panel[i] - centre).cwiseProduct(per_scale);
    for (std::size_t i = 0; i < N; ++i) s[i] = u[i].squaredNorm();
    for (std::size_t i = 0; i < N; ++i) out[i].inside = out[i].inside && s[i] <= end_radius2_[c];
    if constexpr (requires { profile.scale(s); }) {
      profile.scale(s);
    } else {
      for (std::size_t i = 0; i < N; ++i) s[i] = profile.scale(s[i]);
    }
    for (std::size_t i = 0; i < N; ++i) out[i].ideal[c] = centre + scale.cwiseProduct(Vector2(u[i] * s[i]));
  }

  void cut_to_field(std::size_t count, PanelLook* out) const {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; out[i].inside && c < static_cast<std::size_t>(colours_); ++c) {
        const Vector2& t = out[i].ideal[c];
        out[i].inside = t.x() >= field_->left && t.x() <= field_->right && t.y() >= field_->down && t.y() <= field_->up;
      }
    }
  }

  std::array<Lens, 3> lenses_;
  std::array<double, 3> end_radius2_{};
  int colours_ = 1;
  bool inverse_, identity_, smooth_ = true, radial_ = true, has_end_ = false;
  std::optional<FieldTangents> field_;
};

}  // namespace holdfast::detail
