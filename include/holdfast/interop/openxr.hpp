/// Fields, poses, views and times to and from OpenXR. Target holdfast::openxr; needs OpenXR's headers, no loader.
///
/// Frames agree (+X right, +Y up, -Z forward, metres), and so do an XrFovf's signs (radians; right and up positive;
/// swapped pairs mean a mirrored picture). Quaternions and vectors are copied by name, never by memory order. OpenXR
/// has 32-bit floats: what is written is rounded. XrTime counts nanoseconds, 0 and below mean no time; it is a HostTime
/// only where the runtime's clock is the host's (CLOCK_MONOTONIC on Linux: XR_KHR_convert_timespec_time).
/// Views must be located in the VIEW reference space: then their poses are the eyes' in the head. The head frame here
/// lies midway between the eyes, OpenXR's VIEW space perhaps not: only directions are kept of it, and the shift is
/// answered. A runtime corrects its lens itself: a headset from views has none. Bad input: XrHmd and the optionals
/// name it or are empty.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <openxr/openxr.h>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

// ---- to OpenXR

[[nodiscard]] inline XrFovf to_xr(const FieldTangents& t) {
  return {static_cast<float>(std::atan(t.left)), static_cast<float>(std::atan(t.right)),
          static_cast<float>(std::atan(t.up)), static_cast<float>(std::atan(t.down))};
}

[[nodiscard]] inline XrVector3f to_xr(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

[[nodiscard]] inline XrQuaternionf to_xr(const Quaternion& q) {
  return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()), static_cast<float>(q.w())};
}

[[nodiscard]] inline XrPosef to_xr(const Rigid& X_AB) {
  return {to_xr(X_AB.q()), to_xr(X_AB.p())};
}

[[nodiscard]] inline XrTime to_xr(HostTime t) {
  return t.time_since_epoch().count();
}

/// An eye as a view of the VIEW space; of a picture drawn for EyeModel::tangents.
[[nodiscard]] inline XrView to_xr(const EyeModel& eye) {
  XrView view{};
  view.type = XR_TYPE_VIEW;
  view.pose = to_xr(eye.X_HE);
  view.fov = to_xr(eye.tangents);
  return view;
}

[[nodiscard]] inline std::array<XrView, 2> to_xr(const HmdModel& hmd) {
  return {to_xr(hmd.left), to_xr(hmd.right)};
}

// ---- from OpenXR

[[nodiscard]] inline FieldResult from_xr(const XrFovf& fov) {
  return tangents_of(FieldAngles{radians(double(fov.angleLeft)), radians(double(fov.angleRight)),
                                 radians(double(fov.angleDown)), radians(double(fov.angleUp))});
}

[[nodiscard]] inline Vector3 from_xr(const XrVector3f& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

/// Nothing when it is not finite, or off unit length by more than the 1 % that OpenXR allows.
[[nodiscard]] inline std::optional<Quaternion> from_xr(const XrQuaternionf& q) {
  const Quaternion out(double(q.w), double(q.x), double(q.y), double(q.z));
  const double length = out.norm();
  if (!(std::abs(length - 1.0) <= 0.01)) return std::nullopt;
  return out.normalized();
}

[[nodiscard]] inline std::optional<Rigid> from_xr(const XrPosef& pose) {
  const std::optional<Quaternion> q = from_xr(pose.orientation);
  const Vector3 p = from_xr(pose.position);
  if (!q || !p.allFinite()) return std::nullopt;
  return Rigid(*q, p);
}

/// Nothing for a time of 0 or below.
[[nodiscard]] inline std::optional<HostTime> host_time_of_xr(XrTime time) {
  if (time <= 0) return std::nullopt;
  return HostTime(Duration(std::int64_t{time}));
}

/// A headset from its views, or what is wrong with them.
struct XrHmd {
  HmdModel hmd;
  std::string_view problem;        ///< empty: none
  Vector3 p_VH = Vector3::Zero();  ///< the head frame's origin in the VIEW space

  [[nodiscard]] bool ok() const { return problem.empty(); }
};

/// From xrLocateViews in the VIEW space (stereo: left, right) and the sizes that are drawn for each eye.
[[nodiscard]] inline XrHmd hmd_of_xr(const std::array<XrView, 2>& views, const std::array<PixelSize, 2>& sizes,
                                     double refresh_hz, std::string name = "OpenXR headset") {
  XrHmd out;
  const auto fail = [&](std::string_view problem) {
    out.problem = problem;
    return out;
  };
  std::array<Rigid, 2> X_VE;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::optional<Rigid> pose = from_xr(views[i].pose);
    if (!pose) return fail("a view's pose is not finite, or its quaternion not of unit length");
    const FieldResult field = from_xr(views[i].fov);
    if (!field.ok()) return fail(describe(field.problem));
    if (sizes[i].width < 1 || sizes[i].height < 1) return fail("a view has no pixels");
    X_VE[i] = *pose;
    EyeModel& eye = i == 0 ? out.hmd.left : out.hmd.right;
    eye.side = i == 0 ? EyeSide::left : EyeSide::right;
    eye.tangents = field.tangents;
    eye.resolution = sizes[i];
  }
  const Vector3 across = X_VE[1].p() - X_VE[0].p();
  if (!(across.x() > 0.0)) return fail("the right view is not to the right of the left one");
  if (!(refresh_hz >= 1.0 && refresh_hz <= 1e6)) return fail("the refresh rate is not 1 to 1e6 Hz");
  out.p_VH = (X_VE[0].p() + X_VE[1].p()) / 2.0;
  out.hmd.left.X_HE = Rigid(X_VE[0].q(), X_VE[0].p() - out.p_VH);
  out.hmd.right.X_HE = Rigid(X_VE[1].q(), X_VE[1].p() - out.p_VH);
  out.hmd.ipd_m = across.norm();
  out.hmd.name = std::move(name);
  out.hmd.source = "views of an OpenXR runtime, which corrects the lenses itself";
  out.hmd.timing.refresh_hz = refresh_hz;
  return out;
}

}  // namespace holdfast
