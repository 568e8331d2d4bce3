// Table 8.1 of Robinett & Holloway 1994 as a descriptor, with the decimal points that the scan lost put back, and with
// the paraxial window. Written out here rather than taken from optics/, which is a layer above frames.
#pragma once

#include <cmath>
#include <string>

#include <holdfast/frames/display_chain.hpp>

inline const holdfast::Vector2 left_axis(395.9, 256), right_axis(244.1, 256);  // px
inline constexpr double r_norm_px = 256, k_n = 0.1933;

/// Eq. 7.9.2: where the lens shows what is drawn at p_S.
inline holdfast::Vector2 distort(const holdfast::Vector2& axis, const holdfast::Vector2& p_S) {
  const holdfast::Vector2 d = (p_S - axis) / r_norm_px;
  const double grow = 1 + k_n * d.squaredNorm();
  return axis + r_norm_px * grow * d;
}

/// Its inverse T_S_US, by Newton's method on the radius.
inline holdfast::Vector2 undistort(const holdfast::Vector2& axis, const holdfast::Vector2& p_US) {
  const holdfast::Vector2 d = (p_US - axis) / r_norm_px;
  const double r_v = d.norm();
  if (r_v == 0) return p_US;
  double r = r_v;
  for (int i = 0; i < 20; ++i) r -= (r + k_n * r * r * r - r_v) / (1 + 3 * k_n * r * r);
  return axis + (r_norm_px * r / r_v) * d;
}

/// Section 7.7: from the window's centre x_cw and size, at z_p, with the clip planes of the table.
inline holdfast::Matrix4 perspective(double x_cw) {
  const double z_p = -1.18, w_x = 1.57, w_y = 1.19, near = 0.05, far = 1000;
  const double left = -near * (x_cw - w_x / 2) / z_p, right = -near * (x_cw + w_x / 2) / z_p;
  const double top = -near * (w_y / 2) / z_p, bottom = -top;
  holdfast::Matrix4 T_NE;
  T_NE << 2 * near / (right - left), 0, (right + left) / (right - left), 0,  //
      0, 2 * near / (top - bottom), (top + bottom) / (top - bottom), 0,      //
      0, 0, -(far + near) / (far - near), -2 * far * near / (far - near),    //
      0, 0, -1, 0;
  return T_NE;
}

/// Section 7.8 for a viewport of 640 x 512 px.
inline holdfast::Matrix4 viewport() {
  holdfast::Matrix4 T_US_N;
  T_US_N << 320, 0, 0, 320, 0, 256, 0, 256, 0, 0, 1, 0, 0, 0, 0, 1;
  return T_US_N;
}

inline holdfast::EyeDescriptor flight_helmet_eye(const std::string& name, double side, const holdfast::Vector2& axis) {
  using namespace holdfast;
  return {name, Rigid::translation(Vector3(side * 0.062 / 2, 0, 0)), perspective(side * 0.187), viewport(),
          [axis](const Vector2& p_US) { return std::optional<Vector2>(undistort(axis, p_US)); }};
}

inline holdfast::UserDescriptor flight_helmet_user(const std::string& name) {
  using namespace holdfast;
  UserDescriptor user;
  user.name = name;
  user.X_R_TB = Rigid(Quaternion(-0.5, 0.5, 0.5, -0.5), Vector3(2.5, 2.0, 2.0));
  user.X_H_HS = Rigid(Quaternion(0.5, 0.5, 0.5, -0.5), Vector3(0, 0.19, 0));
  user.eyes = {flight_helmet_eye("LE", -1, left_axis), flight_helmet_eye("RE", 1, right_axis)};
  return user;
}

/// What the tracker reports while the head is at (2.5, 1.0, 1.7) of the room, upright, looking north; by hand: the
/// sensor is 0.19 m above the head's centre, (2.5, 1.0, 1.89). The base at (2.5, 2, 2) has its axes north, down, west;
/// so p_TB_HS = (-1, 0.11, 0). The sensor's axes on the head are ahead, right, down: north, east, down = +X, -Z, +Y of
/// the base: a turn of -90 deg about X.
inline holdfast::Vqs tracker_pose_looking_north() {
  using namespace holdfast;
  return Rigid(Quaternion(std::sqrt(0.5), -std::sqrt(0.5), 0, 0), Vector3(-1, 0.11, 0));
}
