/// The lens before an eye: any model, where it stands among the eye's tangents, and what the paper's cubic does.
///
/// A model (LensModel) works in its own unit round its own origin. LensPlacement says where that is: a point u of the
/// model is the tangent t = centre + scale .* u, on the panel and as seen. So
///
///     distort(t) = centre + scale .* model.distort((t - centre) ./ scale)
///
/// and mirroring, moving or scaling a lens changes its placement alone, whatever the model. k_pd is the coefficient of
/// Robinett & Holloway's cubic predistortion u (1 + k_pd |u|^2), kept for comparison (000 7.9). Bad input: a point
/// outside the model's domain is answered with nothing; a scale must be finite and not zero (asserted, and named by
/// problem_of). What an application does about the lens is in lens_mode.hpp.
#pragma once

#include <cmath>
#include <concepts>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/bivariate_lens.hpp>
#include <holdfast/optics/brown_conrady_lens.hpp>
#include <holdfast/optics/catmull_rom_lens.hpp>
#include <holdfast/optics/kannala_brandt_lens.hpp>
#include <holdfast/optics/lens_model.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/point_mesh_lens.hpp>
#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/power_series_lens.hpp>
#include <holdfast/optics/radial_lens.hpp>
#include <holdfast/optics/reversed_lens.hpp>
#include <holdfast/optics/vive_lens.hpp>

namespace holdfast {

/// t = centre + scale .* u; tangents of field angle.
struct LensPlacement {
  Vector2 centre = Vector2::Zero();  ///< where the model's origin is, usually the optical axis
  Vector2 scale = Vector2::Ones();   ///< tangents per unit of the model; negative mirrors it

  friend bool operator==(const LensPlacement&, const LensPlacement&) = default;
};

/// Where u = 1 is at r_norm tangents from the centre, in every direction.
[[nodiscard]] inline LensPlacement placed_at(double r_norm, const Vector2& centre = Vector2::Zero()) {
  return {centre, Vector2(r_norm, r_norm)};
}

/// What makes a placement unusable: zero_scale or not_finite, else none.
[[nodiscard]] inline LensProblem problem_of(const LensPlacement& placement) {
  const Vector2& s = placement.scale;
  if (!s.allFinite() || !placement.centre.allFinite()) return LensProblem::not_finite;
  return s.x() != 0.0 && s.y() != 0.0 ? LensProblem::none : LensProblem::zero_scale;
}

class Lens {
 public:
  using Model =
      std::variant<NoLens, RadialLens, PolynomialLens, PowerSeriesLens, ViveLens, CatmullRomLens, KannalaBrandtLens,
                   BrownConradyLens, BivariateLens, PointMeshLens, ReversedLens<PolynomialLens>,
                   ReversedLens<PowerSeriesLens>, ReversedLens<BrownConradyLens>>;

  Lens() = default;

  /// Any model is a lens, by default centred on the eye's axis with its unit as the tangents'.
  template <LensModel M>
  requires(!std::same_as<M, Lens> && std::is_constructible_v<Model, M>)
      Lens(M model, const LensPlacement& placement = {}, double k_pd = 0.0)
      : Lens(Model(std::move(model)), placement, k_pd) {}

  Lens(Model model, const LensPlacement& placement, double k_pd = 0.0)
      : model_(std::move(model)), placement_(placement), k_pd_(k_pd) {
    HOLDFAST_ASSERT(problem_of(placement) == LensProblem::none, "a lens's scale must be finite and not zero");
    HOLDFAST_ASSERT(std::isfinite(k_pd), "a lens's numbers must be finite");
  }

  [[nodiscard]] const Model& model() const { return model_; }
  /// The model if it is an M, else null.
  template <LensModel M>
  [[nodiscard]] const M* model_if() const {
    return std::get_if<M>(&model_);
  }
  [[nodiscard]] const LensPlacement& placement() const { return placement_; }
  [[nodiscard]] const Vector2& centre() const { return placement_.centre; }
  [[nodiscard]] double k_pd() const { return k_pd_; }

  /// The same lens elsewhere, or with another cubic.
  [[nodiscard]] Lens with_placement(const LensPlacement& placement) const { return {model_, placement, k_pd_}; }
  [[nodiscard]] Lens with_k_pd(double k_pd) const { return {model_, placement_, k_pd}; }

  /// Where the panel point of tangent `panel` is seen.
  [[nodiscard]] std::optional<Vector2> distort(const Vector2& panel) const {
    if (std::holds_alternative<NoLens>(model_)) return panel;  // to the last bit
    const Vector2 u = to_model(panel);
    return from_model(with_model([&](const auto& m) { return m.distort(u); }));
  }
  /// The panel point that is seen at tangent `seen`.
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& seen) const {
    if (std::holds_alternative<NoLens>(model_)) return seen;
    const Vector2 u = to_model(seen);
    return from_model(with_model([&](const auto& m) { return m.undistort(u); }));
  }
  /// d distort / d panel.
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& panel) const {
    const Vector2 u = to_model(panel);
    return from_model(Matrix2(with_model([&](const auto& m) { return m.distort_jacobian(u); })));
  }
  /// d undistort / d seen; nothing outside the domain and where it is infinite.
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& seen) const {
    const Vector2 u = to_model(seen);
    const std::optional<Matrix2> J = with_model([&](const auto& m) { return m.undistort_jacobian(u); });
    return J ? std::optional<Matrix2>(from_model(*J)) : std::nullopt;
  }
  /// The largest disc round the centre, in tangents, inside which distort is known to be one-to-one.
  [[nodiscard]] double valid_radius() const {
    return smaller_scale() * with_model([](const auto& m) { return m.valid_radius(); });
  }
  /// The largest disc round the centre, in seen tangents, that undistort surely answers.
  [[nodiscard]] double valid_image_radius() const {
    return smaller_scale() * with_model([](const auto& m) { return m.valid_image_radius(); });
  }

  /// The paper's predistortion u (1 + k_pd |u|^2), itself a lens: draw at cubic_inverse().distort(ideal).
  [[nodiscard]] Lens cubic_inverse() const { return {RadialLens{k_pd_}, placement_}; }

  friend bool operator==(const Lens&, const Lens&) = default;

 private:
  /// std::visit, which takes an indirect call for so many, with the most common models first.
  template <typename Function>
  [[nodiscard]] std::invoke_result_t<const Function&, const RadialLens&> with_model(const Function& f) const {
    if (const auto* radial = std::get_if<RadialLens>(&model_)) return f(*radial);
    if (const auto* polynomial = std::get_if<PolynomialLens>(&model_)) return f(*polynomial);
    return std::visit(f, model_);
  }
  [[nodiscard]] Vector2 to_model(const Vector2& t) const {
    return (t - placement_.centre).cwiseQuotient(placement_.scale);
  }
  [[nodiscard]] std::optional<Vector2> from_model(const std::optional<Vector2>& u) const {
    if (!u) return std::nullopt;
    return Vector2(placement_.centre + placement_.scale.cwiseProduct(*u));
  }
  [[nodiscard]] Matrix2 from_model(const Matrix2& J) const {
    const Vector2& s = placement_.scale;
    Matrix2 out;
    out << J(0, 0), J(0, 1) * (s.x() / s.y()), J(1, 0) * (s.y() / s.x()), J(1, 1);
    return out;
  }
  [[nodiscard]] double smaller_scale() const { return placement_.scale.cwiseAbs().minCoeff(); }

  Model model_;
  LensPlacement placement_;
  double k_pd_ = 0.0;
};

/// The lens as seen from an eye for which every panel tangent t has become scale * t + shift.
[[nodiscard]] inline Lens moved(const Lens& lens, double scale, const Vector2& shift) {
  const LensPlacement& p = lens.placement();
  return lens.with_placement({Vector2(p.centre * scale + shift), Vector2(p.scale * scale)});
}

/// The lens of the other eye: left and right change places.
[[nodiscard]] inline Lens mirrored(const Lens& lens) {
  const LensPlacement& p = lens.placement();
  return lens.with_placement({Vector2(-p.centre.x(), p.centre.y()), Vector2(-p.scale.x(), p.scale.y())});
}

}  // namespace holdfast
