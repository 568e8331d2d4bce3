// Random eyes, views and motions for the tests of deflection, all with fixed seeds.
#pragma once

#include <array>
#include <cmath>
#include <random>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/deflect.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine_); }
  bool coin() { return index(2) == 0; }
  Vector3 vector(double largest) {
    return {uniform(-largest, largest), uniform(-largest, largest), uniform(-largest, largest)};
  }
  Quaternion turn(double largest) { return so3::exp<double>(vector(largest)); }
  Rigid pose(double largest_turn, double largest_step) { return {turn(largest_turn), vector(largest_step)}; }

  FieldTangents field() { return {uniform(-1.3, -0.5), uniform(0.4, 1.2), uniform(-1.1, -0.4), uniform(0.3, 1.0)}; }

  // Any field, panel, canting and mounting; a lens of either sign that is one-to-one over the field.
  EyeModel eye() {
    EyeModel eye;
    eye.side = coin() ? EyeSide::left : EyeSide::right;
    eye.X_HE = eye_pose(eye.side, uniform(0.05, 0.07), degrees(uniform(-20.0, 20.0)), degrees(uniform(-8.0, 8.0)));
    eye.tangents = field();
    eye.resolution = {200 + index(1800), 200 + index(1800)};
    eye.upside_down = coin();
    const Vector2 centre(uniform(-0.1, 0.1), uniform(-0.1, 0.1));
    eye.lens = Lens(RadialLens{uniform(-0.02, 0.2)}, placed_at(0.9, centre), -0.1);
    if (coin()) eye.lens_red = Lens(RadialLens{uniform(-0.02, 0.2)}, placed_at(0.9, centre), -0.1);
    if (coin()) eye.lens_blue = Lens(RadialLens{uniform(-0.02, 0.2)}, placed_at(0.9, centre), -0.1);
    return eye;
  }

  DisplayTiming timing(bool rolling) {
    DisplayTiming timing;
    timing.scan_out = rolling ? ScanOut::rolling : ScanOut::global;
    timing.scan_duration = from_milliseconds(11.1);
    timing.scan_direction = scan_directions[static_cast<std::size_t>(index(4))];
    return timing;
  }

  // A picture with the eye's field, or wider, at any size; mirrored now and then.
  RenderedView view(const EyeModel& eye) {
    const double wider = uniform(1.0, 1.2);
    FieldTangents t = eye.tangents;
    for (double* edge : {&t.left, &t.right, &t.down, &t.up}) *edge *= wider;
    if (index(5) == 0) std::swap(t.left, t.right);
    return {pose(3.0, 5.0), t, {200 + index(1800), 200 + index(1800)}, {}};
  }

  // A point ahead of an eye, inside its field.
  Vector3 point_E(const EyeModel& eye, double nearest, double farthest) {
    const double z = uniform(nearest, farthest);
    return {z * uniform(eye.tangents.left, eye.tangents.right), z * uniform(eye.tangents.down, eye.tangents.up), -z};
  }

 private:
  std::mt19937 engine_;
};

// The eye S has turned at the angular velocity w_S (rad/s, in S) and moved at v_W (m/s) when the scan begins, and goes
// on doing so during it.
inline LatePoses moved_on(const RenderedView& view, const Vector3& w_S, const Vector3& v_W, double begin_s,
                          double scan_s) {
  const auto at = [&](double t) {
    const Vector3 phi = w_S * t;
    return Rigid(view.X_WS.q() * so3::exp<double>(phi), view.X_WS.p() + v_W * t);
  };
  return {at(begin_s), at(begin_s + scan_s)};
}

}  // namespace holdfast::test
