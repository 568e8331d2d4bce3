/// A picture together with the view that it was drawn with, so that no late correction can start from the wrong pose.
///
/// RenderedView says what a picture was drawn with: the pose X_WS of the source eye frame S in the world, the signed
/// tangents of the picture's edges (those of the projection matrix; usually wider than the panel's: see overfill), its
/// size in pixels, and the time its pose was meant for. RenderedPicture binds a picture of any type (an image, a
/// texture's handle, a swap-chain index) to its view for good: there is no way to change one without the other.
/// Source pixels: origin at the lower left, centres at half integers; an edge pair in swapped order is a mirrored
/// picture. Source: the need is peers.md's "the wrong render pose handed to the warp".
/// Bad input: deflect() tells what is wrong with a view; pixels of an impossible field are not finite.
#pragma once

#include <utility>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/tangents.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// What a picture was drawn with.
struct RenderedView {
  Rigid X_WS;              ///< p_W = X_WS * p_S
  FieldTangents tangents;  ///< of the picture's edges
  PixelSize size;          ///< of the picture
  HostTime t{};            ///< the moment of display that the pose was predicted for
};

/// Source pixels per unit of tangent; negative along a mirrored axis.
[[nodiscard]] inline Vector2 pixels_per_tangent(const RenderedView& view) {
  const FieldTangents& t = view.tangents;
  return {view.size.width / (t.right - t.left), view.size.height / (t.up - t.down)};
}

/// The source pixel at which the picture shows the direction t_S; it may lie outside the picture: see is_inside.
[[nodiscard]] inline Vector2 source_pixel_of_tangent(const RenderedView& view, const Vector2& t_S) {
  const Vector2 scale = pixels_per_tangent(view);
  return {(t_S.x() - view.tangents.left) * scale.x(), (t_S.y() - view.tangents.down) * scale.y()};
}

/// The direction t_S that a source pixel shows.
[[nodiscard]] inline Vector2 tangent_of_source_pixel(const RenderedView& view, const Vector2& source_pixel) {
  const Vector2 scale = pixels_per_tangent(view);
  return {view.tangents.left + source_pixel.x() / scale.x(), view.tangents.down + source_pixel.y() / scale.y()};
}

[[nodiscard]] inline bool is_inside(const RenderedView& view, const Vector2& source_pixel) {
  return source_pixel.x() >= 0.0 && source_pixel.y() >= 0.0 && source_pixel.x() <= view.size.width &&
         source_pixel.y() <= view.size.height;
}

/// A picture and the view it was drawn with. They are given once, together; assignment replaces both.
template <typename Picture>
class RenderedPicture {
 public:
  explicit RenderedPicture(const RenderedView& view, Picture picture) : view_(view), picture_(std::move(picture)) {}

  [[nodiscard]] const RenderedView& view() const { return view_; }
  [[nodiscard]] const Picture& picture() const { return picture_; }

 private:
  RenderedView view_;
  Picture picture_;
};

}  // namespace holdfast
