/// A headset: two eyes, the distance between them, and when its display gives light.
///
/// Head frame H: origin midway between the eyes, +X right, +Y up, -Z forward, metres. The eyes sit at (-IPD/2, 0, 0)
/// and
/// (+IPD/2, 0, 0) (Robinett & Holloway 1994, course 11, 7.6). Canted or diverged optics turn the eye frames: eye_pose.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/rigid.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

struct HmdModel {
  std::string name;
  std::string source;    ///< where the numbers come from
  double ipd_m = 0.062;  ///< distance between the eyes
  bool optics_follow_ipd =
      false;  ///< the headset's optics are set to the wearer's IPD; else x_cw changes with it (figure 7.3)
  EyeModel left;
  EyeModel right;
  DisplayTiming timing;

  [[nodiscard]] const EyeModel& eye(EyeSide side) const { return side == EyeSide::left ? left : right; }
  [[nodiscard]] EyeModel& eye(EyeSide side) { return side == EyeSide::left ? left : right; }
};

/// Pose X_HE of an eye whose optical axis is turned outward by `divergence`/2 (000 7.6; negative: the axes converge)
/// and upward by `tilt_up`. The paper prints q_LE_H = [(0, sin(phi/4), 0), cos(phi/4)]; for axes that diverge by phi >
/// 0 that is q_H_LE.
[[nodiscard]] inline Rigid eye_pose(EyeSide side, double ipd_m, Angle divergence = radians(0.0),
                                    Angle tilt_up = radians(0.0)) {
  const double sign = side == EyeSide::left ? 1.0 : -1.0;
  const Vector3 outward(0.0, sign * divergence.radians() / 2.0, 0.0);
  const Vector3 upward(tilt_up.radians(), 0.0, 0.0);
  const Quaternion q_HE = so3::exp<double>(outward) * so3::exp<double>(upward);
  return Rigid(q_HE, Vector3(-sign * ipd_m / 2.0, 0.0, 0.0));
}

namespace detail {

/// `change` done to each lens of an eye, or of a table's row.
template <typename HasLenses, typename Change>
void change_lenses(HasLenses& eye, const Change& change) {
  eye.lens = change(eye.lens);
  if (eye.lens_red) eye.lens_red = change(*eye.lens_red);
  if (eye.lens_blue) eye.lens_blue = change(*eye.lens_blue);
}

inline void move_optics(EyeModel& eye, double scale, const Vector2& shift) {
  const FieldTangents t = eye.tangents;
  eye.tangents = {t.left * scale + shift.x(), t.right * scale + shift.x(), t.down * scale + shift.y(),
                  t.up * scale + shift.y()};
  const auto change = [&](const Lens& lens) { return moved(lens, scale, shift); };
  change_lenses(eye, change);
  for (LensesAtRelief& row : eye.lenses_at_relief) change_lenses(row, change);
}

}  // namespace detail

/// The other eye of a symmetric headset: everything reflected in the plane between the eyes.
[[nodiscard]] inline EyeModel mirrored(const EyeModel& eye) {
  EyeModel other = eye;
  other.side = eye.side == EyeSide::left ? EyeSide::right : EyeSide::left;
  const Quaternion& q = eye.X_HE.q();
  const Vector3& p = eye.X_HE.p();
  other.X_HE = Rigid(Quaternion(q.w(), q.x(), -q.y(), -q.z()), Vector3(-p.x(), p.y(), p.z()));
  other.tangents = mirrored(eye.tangents);
  const auto change = [](const Lens& lens) { return mirrored(lens); };
  detail::change_lenses(other, change);
  for (LensesAtRelief& row : other.lenses_at_relief) detail::change_lenses(row, change);
  return other;
}

/// The headset on a wearer of another IPD. The eyes move; optics that do not follow stay, so that each window's centre
/// moves against its eye: x_cw = x_H_CW +- IPD/2 (figure 7.3). With a collimated image (image_distance_m infinite)
/// nothing else changes.
[[nodiscard]] inline HmdModel with_ipd(HmdModel hmd, double ipd_m) {
  for (EyeModel* eye : {&hmd.left, &hmd.right}) {
    const Vector3 old_p = eye->X_HE.p();
    const double x = (eye->side == EyeSide::left ? -0.5 : 0.5) * ipd_m;
    const Vector3 moved_H(x - old_p.x(), 0.0, 0.0);
    eye->X_HE = Rigid(eye->X_HE.q(), old_p + moved_H);
    if (hmd.optics_follow_ipd || std::isinf(eye->image_distance_m)) continue;
    // The image stays where it is: in E it moves against the eye, sideways and, with canted axes, also in depth.
    const Vector3 moved_E = eye->X_HE.q().conjugate() * moved_H;
    const double old_distance = eye->image_distance_m;
    eye->image_distance_m += moved_E.z();
    detail::move_optics(*eye, old_distance / eye->image_distance_m,
                        Vector2(-moved_E.x(), -moved_E.y()) / eye->image_distance_m);
  }
  hmd.ipd_m = ipd_m;
  return hmd;
}

/// The headset worn with another distance of the eyes from the lenses. The virtual image stays where it is, so its
/// tangents shrink as the eye goes back. An eye whose lenses were measured at several reliefs takes its lenses from
/// there (lenses_at), in the tangents that they were measured in. Precondition: the relief is known (eye_relief_m > 0)
/// and stays positive.
[[nodiscard]] inline HmdModel with_eye_relief(HmdModel hmd, double eye_relief_m) {
  for (EyeModel* eye : {&hmd.left, &hmd.right}) {
    HOLDFAST_ASSERT(eye->eye_relief_m > 0.0 && eye_relief_m > 0.0, "the eye relief must be known and positive");
    const double back = eye_relief_m - eye->eye_relief_m;
    eye->X_HE = eye->X_HE * Rigid::translation(Vector3(0.0, 0.0, back));
    eye->eye_relief_m = eye_relief_m;
    const std::vector<LensesAtRelief> table = eye->lenses_at_relief;
    if (!std::isinf(eye->image_distance_m)) {
      const double old_distance = eye->image_distance_m;
      eye->image_distance_m += back;
      detail::move_optics(*eye, old_distance / eye->image_distance_m, Vector2::Zero());
    }
    if (const std::optional<LensesAtRelief> lenses = lenses_at(table, eye_relief_m)) {
      eye->lens = lenses->lens;
      eye->lens_red = lenses->lens_red;
      eye->lens_blue = lenses->lens_blue;
      eye->lenses_at_relief = table;
    }
  }
  return hmd;
}

/// The same headset with pictures of another size per eye. The field stays, so the pixels change their size and perhaps
/// aspect.
[[nodiscard]] inline HmdModel with_resolution(HmdModel hmd, PixelSize size) {
  hmd.left.resolution = size;
  hmd.right.resolution = size;
  return hmd;
}

/// A plain see-through headset for experiments that name none: square pixels, 60 degrees wide, collimated image, 90 Hz,
/// IPD 62 mm. Its lens is as strong as the Flight Helmet's (k = 0.1933 at half the picture's height), with the paper's
/// k_pd = -0.1.
[[nodiscard]] inline HmdModel default_hmd(PixelSize size = {1280, 720}) {
  HmdModel hmd;
  hmd.name = "Holdfast default see-through";
  hmd.source = "invented for the default experiments; lens: course 11, table 8.1";
  const double half_width = tan(degrees(30.0));
  const double half_height = half_width * size.height / size.width;
  for (EyeModel* eye : {&hmd.left, &hmd.right}) {
    eye->side = eye == &hmd.left ? EyeSide::left : EyeSide::right;
    eye->X_HE = eye_pose(eye->side, hmd.ipd_m);
    eye->tangents = {-half_width, half_width, -half_height, half_height};
    eye->resolution = size;
    eye->lens = Lens(RadialLens{0.1933}, placed_at(half_height), -0.1);
  }
  return hmd;
}

}  // namespace holdfast
