/// The HiBall, a ball of six lenses and six photodiodes, and its ceiling (HiBall paper 4.1, 5.1; 002 appendices D, E).
///
/// Frame B, the HiBall's: origin in the ball's centre, z out through the top lens (HiBall paper 5.1), the lens of view 1
/// tilted towards x, views 2 to 5 following anticlockwise seen from above. On a head that looks along +y of B this is
/// 002's "upright".
/// Geometry: lens i sits at r n_i and photodiode j opposite to lens j at -r n_j, facing it, with n_0 = z and the other
/// five unit vectors n_i tilted from it by `spacing`, 72 deg apart round it: the upper six faces of a dodecahedron.
///   primary views    light through lens i on photodiode i: along n_i, with the focal distance 2 r
///   secondary views  light through lens i on the photodiode j of a neighbouring face: along n_i + n_j, half-way between two
///                    primary views, on a photodiode that stands aslant by half the spacing. Five pass through the top
///                    lens; each other lens has three neighbours among the six (the top and two beside it): 5 + 5 * 3 = 20.
/// Each view is a pinhole in its lens with the photodiode's plane as image plane, so its view matrix is exact for the
/// slanted ones too; (u, v) has its origin in the photodiode's middle.
/// Numbers: both papers say six views "uniformly" 57 deg apart, but also dodecahedral symmetry, whose neighbouring faces
/// are acos(1/sqrt 5) = 63.43 deg apart, the only angle that six axes can all have with each other. 57 deg is taken for
/// the tilt from the top view; then neighbours among the five are 59.1 deg apart. `dodecahedral_spacing` is the other
/// reading. Field "less than six degrees" (6.1.1): the photodiode DLS-4 is taken as 4 mm square, and the focal distance of
/// 39 mm, about a golf ball's diameter (002 figure D.3), gives 5.87 deg from side to side.
/// Each true beacon is off its design by a normal error of 1 mm an axis, 1.7 mm RMS (002 6.2.1), by KeyedNumbers.
/// Not modelled: lens distortion (calibrated away by the table of 5.1), and which of several lenses a spot came through.
/// Bad input: `hiball_rig` asserts that the layout has no problem, and that lengths are positive.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/simulation/hiball_ceiling.hpp>
#include <holdfast/simulation/keyed_numbers.hpp>
#include <holdfast/tracking/camera_view.hpp>
#include <holdfast/tracking/sighting_noise.hpp>

namespace holdfast {

/// One lens and one photodiode.
struct HiBallCamera {
  CameraView view;  ///< (u, v) in metres on the photodiode, from its middle
  int lens = 0;
  int photodiode = 0;                ///< the lens's own for a primary view
  Vector3 centre_B;                  ///< the lens, where the rays meet
  Vector3 axis_B;                    ///< unit vector towards the middle of the field
  std::array<Vector3, 4> corners_B;  ///< rays towards the field's corners, not of unit length
  double half_side_m = 0.0;          ///< |u| and |v| are at most this

  [[nodiscard]] bool is_primary() const { return lens == photodiode; }
};

/// Angle between the normals of neighbouring faces of a dodecahedron.
inline const Angle dodecahedral_spacing = radians(std::acos(1.0 / std::sqrt(5.0)));

struct HiBallOptions {
  CeilingLayout ceiling;
  bool secondary_views = false;  ///< 26 views in place of six
  Angle spacing = degrees(57.0);
  double photodiode_m = 0.004;  ///< side of the square
  double focal_m = 0.039;
  double beacon_error_m = 0.001;  ///< standard deviation along each axis of W
  std::uint64_t seed = 1;         ///< of the beacons' errors
  SightingNoise noise;
};

struct HiBallRig {
  CeilingLayout ceiling;
  std::vector<HiBallCamera> cameras;
  std::vector<Vector3> beacons_W;          ///< where they truly are
  std::vector<Vector3> nominal_beacons_W;  ///< where design puts them: what a tracker starts with
  SightingNoise noise;

  [[nodiscard]] int panel_of(int beacon) const { return beacon / CeilingLayout::panel_leds; }
};

/// The view through `lens` on `photodiode`, 0 to 5.
[[nodiscard]] inline HiBallCamera hiball_camera(int lens, int photodiode, const HiBallOptions& options) {
  const auto azimuth = [](int face) { return degrees(72.0 * (face - 1)); };
  const auto face_axis = [&](int face) -> Vector3 {
    if (face == 0) return Vector3::UnitZ();
    const double across = sin(options.spacing);
    return Vector3(across * cos(azimuth(face)), across * sin(azimuth(face)), cos(options.spacing));
  };
  const Vector3 n_lens = face_axis(lens), n_diode = face_axis(photodiode);
  const Vector3 right =
      photodiode == 0 ? Vector3::UnitX() : Vector3(-sin(azimuth(photodiode)), cos(azimuth(photodiode)), 0.0);
  Matrix3 R_BC;
  R_BC << right, right.cross(n_diode), -n_diode;
  const double radius = 0.5 * options.focal_m;

  HiBallCamera camera;
  camera.lens = lens;
  camera.photodiode = photodiode;
  camera.half_side_m = 0.5 * options.photodiode_m;
  camera.centre_B = radius * n_lens;
  camera.axis_B = (n_lens + n_diode).normalized();
  // From the lens to the photodiode's middle is -r (n_lens + n_diode): the image plane's distance, and its middle, mirrored.
  const double plane_m = radius * (1.0 + n_lens.dot(n_diode));
  const Vector2 middle = radius * (R_BC.transpose() * n_lens).head<2>();
  camera.view.V = view_matrix(Rigid(Quaternion(R_BC), camera.centre_B), plane_m);
  camera.view.V.topRows<2>() -= middle * camera.view.V.row(2);
  for (int k = 0; k < 4; ++k) {
    const Vector2 corner = middle + camera.half_side_m * Vector2(k == 0 || k == 3 ? -1.0 : 1.0, k < 2 ? -1.0 : 1.0);
    camera.corners_B[static_cast<std::size_t>(k)] = R_BC * Vector3(corner.x(), corner.y(), -plane_m);
  }
  return camera;
}

/// The six primary views, or all 26: primary ones first, then the secondary ones lens by lens.
[[nodiscard]] inline std::vector<HiBallCamera> hiball_cameras(const HiBallOptions& options) {
  std::vector<HiBallCamera> cameras;
  for (int face = 0; face < 6; ++face) cameras.push_back(hiball_camera(face, face, options));
  if (!options.secondary_views) return cameras;
  const auto neighbours = [](int a, int b) {
    if (a == 0 || b == 0) return a != b;
    return (a - b + 5) % 5 == 1 || (b - a + 5) % 5 == 1;
  };
  for (int lens = 0; lens < 6; ++lens) {
    for (int photodiode = 0; photodiode < 6; ++photodiode) {
      if (neighbours(lens, photodiode)) cameras.push_back(hiball_camera(lens, photodiode, options));
    }
  }
  return cameras;
}

[[nodiscard]] inline HiBallRig hiball_rig(const HiBallOptions& options = {}) {
  HOLDFAST_ASSERT(!options.ceiling.problem(), "the ceiling cannot be built so");
  HOLDFAST_ASSERT(options.photodiode_m > 0.0 && options.focal_m > 0.0, "a camera's lengths must be positive");
  HiBallRig rig;
  rig.ceiling = options.ceiling;
  rig.noise = options.noise;
  rig.cameras = hiball_cameras(options);
  rig.nominal_beacons_W = options.ceiling.places_W();
  rig.beacons_W = rig.nominal_beacons_W;
  for (std::size_t beacon = 0; beacon < rig.beacons_W.size(); ++beacon) {
    KeyedNumbers numbers(options.seed, {static_cast<std::int64_t>(beacon)});
    const Vector2 lateral = numbers.normal_pair(), height = numbers.normal_pair();
    rig.beacons_W[beacon] += options.beacon_error_m * Vector3(lateral.x(), lateral.y(), height.x());
  }
  return rig;
}

/// Displaces a panel with all its beacons, as when somebody pushes against a tile.
inline void move_panel(HiBallRig& rig, int panel, const Vector3& displacement_W) {
  HOLDFAST_ASSERT(panel >= 0 && panel < rig.ceiling.panels(), "there is no such panel");
  const int first = panel * CeilingLayout::panel_leds;
  for (int k = 0; k < CeilingLayout::panel_leds; ++k) {
    rig.beacons_W[static_cast<std::size_t>(first + k)] += displacement_W;
  }
}

}  // namespace holdfast
