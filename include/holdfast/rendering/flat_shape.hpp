/// Discs, rectangles and checkerboards in space, drawn with exact edges.
///
/// A pixel's value is the colour weighted with the part of the pixel's square that lies inside the outline, computed
/// from the outline's distance and direction (shaders/flat_shape.frag), not from a few samples: 4 samples a pixel would
/// leave an error of about 0.03 px in a disc's centroid and, worse, in the place of an upright edge, since all its
/// pixels err alike. Shapes are blended over what is there, so they must come after solid things, and farther ones
/// before nearer ones. The plane of a shape is a homography of the picture: pixel (x, y, 1) -> (u, v, 1) / distance. It
/// is made in double.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/shaders.hpp>
#include <holdfast/rendering/view.hpp>

namespace holdfast::rendering {

/// Point of the shape: p_W = origin_W + u u_axis_W + v v_axis_W.
struct FlatShape {
  enum class Kind {
    disc,       ///< u^2 + v^2 <= 1: the axes are radii, origin the centre
    rectangle,  ///< 0 <= u, v <= 1: the axes are sides, origin a corner
    board,      ///< 0 <= (u, v) <= cells: the axes are one cell's sides, origin a corner
  };
  Kind kind = Kind::disc;
  Vector3 origin_W = Vector3::Zero();
  Vector3 u_axis_W = Vector3::UnitX();
  Vector3 v_axis_W = Vector3::UnitY();
  Vector3 colour = Vector3::Ones();        ///< board: of cell (0, 0)
  Vector3 other_colour = Vector3::Zero();  ///< board: of the cells beside it
  Vector2 cells = Vector2::Ones();         ///< board

  [[nodiscard]] Vector3 centre_W() const {
    if (kind == Kind::disc) return origin_W;
    const Vector2 n = kind == Kind::board ? cells : Vector2(1.0, 1.0);
    return origin_W + 0.5 * (n.x() * u_axis_W + n.y() * v_axis_W);
  }
  /// No point of the shape is farther from its centre.
  [[nodiscard]] double reach_m() const {
    if (kind == Kind::disc) return u_axis_W.norm() + v_axis_W.norm();
    const Vector2 n = kind == Kind::board ? cells : Vector2(1.0, 1.0);
    return 0.5 * (n.x() * u_axis_W.norm() + n.y() * v_axis_W.norm());
  }
};

/// Matrix M: ray_E ~ M (x, y, 1), with z = -1.
[[nodiscard]] inline Matrix3 ray_of_pixel(const EyeModel& eye) {
  const FieldTangents t = panel_tangents(eye);
  const Vector2 s = pixels_per_tangent(eye);
  Matrix3 M;
  M << 1.0 / s.x(), 0.0, t.left, 0.0, 1.0 / s.y(), t.down, 0.0, 0.0, -1.0;
  return M;
}

/// H: pixel (x, y, 1) -> (u, v, 1) / distance along the optical axis. Nothing when the shape is seen edge-on.
[[nodiscard]] inline std::optional<Matrix3> plane_of_pixel(const View& view, const FlatShape& shape) {
  const Rigid X_EW = view.X_WE.inverse();
  Matrix3 axes;
  axes.col(0) = X_EW.q() * shape.u_axis_W;
  axes.col(1) = X_EW.q() * shape.v_axis_W;
  axes.col(2) = X_EW * shape.origin_W;
  const double volume = axes.col(0).norm() * axes.col(1).norm() * axes.col(2).norm();
  if (!(std::abs(axes.determinant()) > 1e-6 * volume)) return std::nullopt;
  return Matrix3(axes.inverse() * ray_of_pixel(*view.eye));
}

/// Whether a ball lies wholly outside one of the planes through the eye and the picture's edges, or behind the near
/// plane.
[[nodiscard]] inline bool is_out_of_view(const View& view, const Vector3& centre_E, double radius) {
  const FieldTangents& t = view.eye->tangents;
  const auto beyond = [&](double offset, double tangent) {  // offset: how far out at this depth, over the edge's own
    return offset > radius * std::hypot(1.0, tangent);
  };
  const double depth = -centre_E.z();
  return depth < view.clip.near_m - radius || beyond(centre_E.x() - t.right * depth, t.right) ||
         beyond(t.left * depth - centre_E.x(), t.left) || beyond(centre_E.y() - t.up * depth, t.up) ||
         beyond(t.down * depth - centre_E.y(), t.down);
}

/// Left, bottom, right, top in pixels of what must be drawn: whole pixels, two more than the outline needs. Nothing
/// when the shape is out of sight. A shape that reaches behind the eye gets the whole picture.
[[nodiscard]] inline std::optional<Vector4> bounds_px(const View& view, const FlatShape& shape) {
  const Rigid X_EW = view.X_WE.inverse();
  const bool disc = shape.kind == FlatShape::Kind::disc;
  const Vector2 high = shape.kind == FlatShape::Kind::board ? shape.cells : Vector2(1.0, 1.0);
  if (is_out_of_view(view, X_EW * shape.centre_W(), shape.reach_m())) return std::nullopt;
  const PixelSize size = view.eye->resolution;
  const double left = std::max(0, view.part.left), right = std::min(size.width, view.part.right);
  const double bottom = std::max(0, view.part.bottom), top = std::min(size.height, view.part.top);
  Vector2 least(1e9, 1e9), most(-1e9, -1e9);
  int behind = 0;
  for (const int corner : {0, 1, 2, 3}) {
    const double u = (corner & 1) != 0 ? high.x() : (disc ? -1.0 : 0.0);
    const double v = (corner & 2) != 0 ? high.y() : (disc ? -1.0 : 0.0);
    const Vector3 p_E = X_EW * Vector3(shape.origin_W + u * shape.u_axis_W + v * shape.v_axis_W);
    const std::optional<Vector2> pixel = -p_E.z() > view.clip.near_m ? project(*view.eye, p_E) : std::nullopt;
    if (!pixel) {
      ++behind;
      continue;
    }
    least = least.cwiseMin(*pixel);
    most = most.cwiseMax(*pixel);
  }
  if (behind == 4) return std::nullopt;
  Vector4 bounds(left, bottom, right, top);
  if (behind == 0) {
    bounds << std::max(left, std::floor(least.x()) - 2.0), std::max(bottom, std::floor(least.y()) - 2.0),
        std::min(right, std::ceil(most.x()) + 2.0), std::min(top, std::ceil(most.y()) + 2.0);
  }
  if (bounds[0] >= bounds[2] || bounds[1] >= bounds[3]) return std::nullopt;
  return bounds;
}

/// Draws flat shapes into the bound target, whose size must be the eye's resolution.
class FlatShapePainter {
 public:
  explicit FlatShapePainter(Context& context)
      : context_(&context),
        program_(context, shaders::flat_shape_vert, shaders::flat_shape_frag),
        no_vertices_(make_vertex_array(context)),
        bounds_(program_.uniform("bounds_px")),
        size_(program_.uniform("size_px")),
        plane_(program_.uniform("plane_of_pixel")),
        depth_(program_.uniform("depth_of_inverse_distance")),
        kind_(program_.uniform("kind")),
        cells_(program_.uniform("cells")),
        colour_(program_.uniform("colour")),
        other_colour_(program_.uniform("other_colour")) {}

  /// Once before a run of draw(): blending over what is there, depth test on.
  void begin(const View& view) const {
    const GlFunctions& gl = context_->gl();
    program_.use();
    gl.BindVertexArray(no_vertices_.id());
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_TRUE);
    gl.Enable(GL_DEPTH_CLAMP);  // a rectangle's corners may lie on its plane's continuation beyond the clipping planes
    gl.Disable(GL_CULL_FACE);
    gl.Enable(GL_BLEND);
    gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const PixelSize size = view.eye->resolution;
    program_.set(size_, Vector2(size.width, size.height));
    const Matrix4 P = projection_matrix(view);
    program_.set(depth_, Vector2(-P(2, 2), P(2, 3)));
  }

  void draw(const View& view, const FlatShape& shape) const {
    const std::optional<Vector4> bounds = bounds_px(view, shape);
    if (!bounds) return;
    const std::optional<Matrix3> H = plane_of_pixel(view, shape);
    if (!H) return;
    program_.set(bounds_, *bounds);
    program_.set(plane_, *H);
    program_.set(kind_, static_cast<int>(shape.kind));
    program_.set(cells_, shape.cells);
    program_.set(colour_, shape.colour);
    program_.set(other_colour_, shape.other_colour);
    context_->gl().DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }

  void end() const {
    context_->gl().Disable(GL_BLEND);
    context_->gl().Disable(GL_DEPTH_CLAMP);
  }

 private:
  Context* context_;
  Program program_;
  GlObject no_vertices_;
  GLint bounds_, size_, plane_, depth_, kind_, cells_, colour_, other_colour_;
};

}  // namespace holdfast::rendering
