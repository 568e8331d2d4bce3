/// What an engine draws one eye with: pose, view and projection matrix, and the picture's size.
///
///     gl.Viewport(0, 0, eye.viewport.width, eye.viewport.height);
///     clip = eye.projection * eye.view * p_W;
///     RenderedPicture picture(eye.rendered_view(), texture);      // what deflection will start from
///
/// The picture is wider than what the panel shows (overfilled), so that a late deflection within its budget still finds
/// something at the edges; its pixels are as dense as they would have been. Frames: W world, E the eye; view = X_EW.
/// Sources: Robinett & Holloway 1994 (course 11), 7.6-7.8. Bad input: an impossible picture is nothing; impossible
/// clipping planes are a programmer's error (problem_of in frame_loop_settings.hpp tells beforehand).
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/optics/overfill.hpp>
#include <holdfast/optics/projection.hpp>
#include <holdfast/pipeline/field_outline.hpp>

namespace holdfast {

/// How the engine wants its matrices.
struct ClipSettings {
  ClipPlanes planes;
  DepthRange depth = DepthRange::minus_one_to_one;
  YDirection y = YDirection::up;
};

/// The smallest picture that fills the outline wherever a deflection within the budget takes it. Preparation: allocates.
/// Nothing when there is none: an empty outline, a budget that is impossible or turns an edge 90 degrees away, or more
/// than 32768 pixels to a side.
[[nodiscard]] inline std::optional<EyePicture> overfilled_picture(const EyeModel& eye, const FieldOutline& outline,
                                                                  const DeflectionBudget& budget) {
  std::vector<Vector2> tangents;
  for (const FieldOutline::Point& point : outline.points()) tangents.push_back(point.t_E);
  const FieldResult field = overfilled_points(tangents, budget);
  if (!field.ok()) return std::nullopt;
  const PixelSize size = overfilled_size(eye, field.value());
  if (std::max(size.width, size.height) > 32768) return std::nullopt;
  return EyePicture{field.value(), size};
}

struct EyeView {
  EyeSide side = EyeSide::left;
  HostTime t{};                              ///< the moment of display that X_WE was predicted for
  Rigid X_WE;                                ///< p_W = X_WE * p_E
  Matrix4 view = Matrix4::Identity();        ///< X_EW
  Matrix4 projection = Matrix4::Identity();  ///< clip = projection * (p_E, 1)
  FieldTangents tangents;                    ///< of the picture's edges
  PixelSize viewport;                        ///< the picture's size

  /// What must travel with the picture that is drawn through this view.
  [[nodiscard]] RenderedView rendered_view() const { return {X_WE, tangents, viewport, t}; }
};

[[nodiscard]] inline EyeView make_eye_view(EyeSide side, const Rigid& X_WE, HostTime t, const EyePicture& picture,
                                           const ClipSettings& clip) {
  EyeView eye;
  eye.side = side;
  eye.t = t;
  eye.X_WE = X_WE;
  eye.view = X_WE.inverse().matrix();
  eye.projection = projection_matrix(picture.tangents, clip.planes, clip.depth, clip.y);
  eye.tangents = picture.tangents;
  eye.viewport = picture.size;
  return eye;
}

}  // namespace holdfast
