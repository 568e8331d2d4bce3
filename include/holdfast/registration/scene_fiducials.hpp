/// The registration scene as data: what the analytic experiments project and the renderer draws, from one description.
///
/// Source: evaluation.md "Default experiments"; the frame corner with its three coloured axes is the registration task
/// of Azuma & Bishop 1994, section 4.2. Frame W: metres, right-handed, +Y up; the viewer's head starts at the origin
/// and looks along -Z. From there nothing hides anything else for either eye (IPD up to 70 mm), and in a 1280 x 720
/// picture of 60 deg by 36 deg every disc has a radius of 17 px or more (more than 8 px down to 640 x 360). Discs with
/// `around` set stand in a ring round the viewer, so that a head which turns away still sees some; those in front of
/// the head do not have it. Colours are linear RGB in [0, 1].
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

/// A flat round disc; its front looks along normal_W (unit length).
struct Disc {
  Vector3 centre_W = Vector3::Zero();
  Vector3 normal_W = Vector3::UnitZ();
  double radius_m = 0.0;
  Vector3 color = Vector3::Ones();
  double nominal_distance_m = 0.0;  ///< 0.5, 1 or 2: its depth in front of the first viewpoint
  bool around = false;              ///< part of the ring, not of the set in front
};

/// The corner of a wooden frame: origin and axes of F, and three square bars along F's positive axes.
struct FrameCorner {
  Rigid X_WF;
  double length_m = 0.0;
  double thickness_m = 0.0;
  std::array<Vector3, 3> colors = {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)};

  [[nodiscard]] Vector3 end_of_axis_W(std::size_t axis) const {
    Vector3 end_F = Vector3::Zero();
    end_F[static_cast<Eigen::Index>(axis)] = length_m;
    return X_WF * end_F;
  }
};

/// A bright upright panel, whose side `bottom_W` - `top_W` is the vertical edge: panel towards across_W, darkness on
/// the other side.
struct VerticalEdge {
  Vector3 bottom_W = Vector3::Zero();
  Vector3 top_W = Vector3::Zero();
  Vector3 across_W = Vector3::Zero();  ///< vector along the panel's width, m
  Vector3 color = Vector3::Ones();

  /// Point of the edge: 0 bottom, 1 top.
  [[nodiscard]] Vector3 point_W(double s) const { return bottom_W + s * (top_W - bottom_W); }
};

/// Squares in the plane z = 0 of C, columns along +x and rows along +y, lower left corner at C's origin; square (0, 0)
/// is bright.
struct Checkerboard {
  Rigid X_WC;
  int columns = 0;
  int rows = 0;
  double square_m = 0.0;
  Vector3 bright = Vector3::Constant(0.9);
  Vector3 dark = Vector3::Constant(0.05);
};

struct RegistrationScene {
  std::vector<Disc> discs;
  FrameCorner corner;
  VerticalEdge edge;
  Checkerboard board;
};

/// The same scene after the whole world was moved: X_VW maps points of W into a new world V.
[[nodiscard]] inline RegistrationScene moved(const RegistrationScene& scene, const Rigid& X_VW) {
  RegistrationScene result = scene;
  for (Disc& disc : result.discs) {
    disc.centre_W = X_VW * disc.centre_W;
    disc.normal_W = X_VW.q() * disc.normal_W;
  }
  result.corner.X_WF = X_VW * scene.corner.X_WF;
  result.edge.bottom_W = X_VW * scene.edge.bottom_W;
  result.edge.top_W = X_VW * scene.edge.top_W;
  result.edge.across_W = X_VW.q() * scene.edge.across_W;
  result.board.X_WC = X_VW * scene.board.X_WC;
  return result;
}

namespace detail {

/// Radius over depth of every disc: 17.7 px in the default eye.
inline constexpr double disc_tangent_radius = 0.016;

/// Disc seen from the first viewpoint at the tangents (x, y), at `depth_m`; `tilt` (rad) turns it about the vertical.
[[nodiscard]] inline Disc disc_at(double depth_m, double x, double y, double tilt, const Vector3& color) {
  Disc disc;
  disc.centre_W = depth_m * Vector3(x, y, -1.0);
  disc.normal_W = Vector3(std::sin(tilt), 0.0, std::cos(tilt));
  disc.radius_m = disc_tangent_radius * depth_m;
  disc.color = color;
  disc.nominal_distance_m = depth_m;
  return disc;
}

/// Disc at an azimuth (deg, to the left positive) and elevation (tangent), facing the origin.
[[nodiscard]] inline Disc disc_around(double distance_m, double azimuth_deg, double tan_elevation,
                                      const Vector3& color) {
  const double a = azimuth_deg * (std::numbers::pi / 180.0);
  Disc disc;
  disc.normal_W = Vector3(std::sin(a), 0.0, std::cos(a));
  disc.centre_W = distance_m * (Vector3(0.0, tan_elevation, 0.0) - disc.normal_W);
  disc.radius_m = disc_tangent_radius * distance_m;
  disc.color = color;
  disc.nominal_distance_m = distance_m;
  disc.around = true;
  return disc;
}

}  // namespace detail

/// The scene of evaluation.md. The first nine discs stand in front: three at each of 0.5, 1 and 2 m; then a ring of 2
/// x 14.
[[nodiscard]] inline RegistrationScene default_registration_scene() {
  RegistrationScene scene;
  const Vector3 amber(1.0, 0.55, 0.1), green(0.35, 0.9, 0.35), blue(0.4, 0.65, 1.0);
  scene.discs = {
      detail::disc_at(0.5, -0.30, -0.20, 0.0, amber), detail::disc_at(0.5, 0.05, 0.25, 0.0, amber),
      detail::disc_at(0.5, 0.36, -0.16, -0.5, amber), detail::disc_at(1.0, -0.14, -0.22, 0.6, green),
      detail::disc_at(1.0, 0.00, -0.26, 0.0, green),  detail::disc_at(1.0, -0.10, 0.22, 0.0, green),
      detail::disc_at(2.0, 0.00, 0.03, 0.0, blue),    detail::disc_at(2.0, -0.36, -0.04, 0.4, blue),
      detail::disc_at(2.0, 0.34, 0.10, 0.0, blue),
  };
  for (int i = 0; i < 14; ++i) {
    const double azimuth = 50.0 + 20.0 * i;
    scene.discs.push_back(detail::disc_around(2.0, azimuth, i % 2 == 0 ? 0.05 : -0.05, blue));
    scene.discs.push_back(detail::disc_around(1.0, azimuth, i % 2 == 0 ? -0.15 : 0.15, green));
  }

  // The corner's three bars come towards the viewer like the edges of a cube seen along its diagonal.
  const Quaternion q_yaw(Eigen::AngleAxisd(-0.25 * std::numbers::pi, Eigen::Vector3d::UnitY()));
  const Quaternion q_pitch(Eigen::AngleAxisd(std::atan(std::sqrt(0.5)), Eigen::Vector3d::UnitX()));
  scene.corner.X_WF = Rigid(q_pitch * q_yaw, Vector3(0.06, -0.144, -1.2));
  scene.corner.length_m = 0.12;
  scene.corner.thickness_m = 0.008;

  scene.edge.bottom_W = Vector3(0.36, -1.5, -2.0);
  scene.edge.top_W = Vector3(0.36, 1.5, -2.0);
  scene.edge.across_W = Vector3(0.12, 0.0, 0.0);

  scene.board.X_WC = Rigid::translation(Vector3(-0.54, 0.03, -1.5));
  scene.board.columns = 6;
  scene.board.rows = 4;
  scene.board.square_m = 0.045;
  return scene;
}

}  // namespace holdfast
