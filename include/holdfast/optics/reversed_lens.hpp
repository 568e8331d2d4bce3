/// Any lens model the other way round: for calibrations whose formula goes from what is seen to the panel.
///
/// Camera calibrations (OpenCV's) take the undistorted direction and give the image point; with the panel in the
/// image's place that is undistort. ReversedLens{model} has undistort = model.distort and distort = model.undistort,
/// each in the other's domain. distort_jacobian outside the domain is not a number.
#pragma once

#include <limits>
#include <optional>
#include <utility>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_model.hpp>

namespace holdfast {

template <LensModel M>
class ReversedLens {
 public:
  ReversedLens() = default;
  explicit ReversedLens(M model) : model_(std::move(model)) {}

  [[nodiscard]] const M& model() const { return model_; }
  [[nodiscard]] double valid_radius() const { return model_.valid_image_radius(); }
  [[nodiscard]] double valid_image_radius() const { return model_.valid_radius(); }
  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const { return model_.undistort(p); }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const { return model_.distort(v); }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    const std::optional<Matrix2> J = model_.undistort_jacobian(p);
    return J ? *J : Matrix2(Matrix2::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    if (!model_.distort(v)) return std::nullopt;
    return model_.distort_jacobian(v);
  }

  friend bool operator==(const ReversedLens&, const ReversedLens&) = default;

 private:
  M model_;
};

}  // namespace holdfast
