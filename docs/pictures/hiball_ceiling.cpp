// Draws docs/pictures/hiball_ceiling.svg: the ceiling seen from above, with the HiBall's 26 fields on it.
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/hiball_ceiling.cpp -o /tmp/hiball_ceiling
//     /tmp/hiball_ceiling > docs/pictures/hiball_ceiling.svg
#include <cstdio>
#include <set>

#include <holdfast/geometry/rays_planes.hpp>
#include <holdfast/simulation/simulation.hpp>

using namespace holdfast;

namespace {

constexpr double scale = 100.0, left = 40.0, top = 50.0;

/// A point of the ceiling's plane on the page, y of L upward.
Vector2 on_page(const CeilingLayout& ceiling, const Vector3& p_L) {
  return Vector2(left + scale * (p_L.x() + 0.5 * ceiling.width_m()), top + scale * (0.5 * ceiling.depth_m() - p_L.y()));
}

void draw_field(const CeilingLayout& ceiling, const HiBallCamera& camera, const Rigid& X_LB) {
  const Plane plane = *Plane::make(Vector3::UnitZ(), Vector3::Zero());
  std::printf("<polygon fill='%s' stroke='%s' stroke-width='1.2' points='", camera.is_primary() ? "#1a4fb530" : "none",
              camera.is_primary() ? "#1a4fb5" : "#b00020");
  for (const Vector3& corner_B : camera.corners_B) {
    const Ray ray_L = X_LB * *Ray::make(camera.centre_B, corner_B);
    const Vector2 p = on_page(ceiling, *intersection(ray_L, plane));
    std::printf("%.1f,%.1f ", p.x(), p.y());
  }
  std::printf("'/>\n");
}

}  // namespace

int main() {
  HiBallOptions options;
  options.secondary_views = true;
  const SplineTrajectory still = still_hiball(
      std::chrono::seconds(1), Rigid(so3::exp<double>(Vector3(-0.05, 0.08, 0.4)), Vector3(2.70, 4.20, 1.45)));
  const HiBallSimulator simulator(hiball_rig(options), still);
  const HiBallRig& rig = simulator.rig();
  const CeilingLayout& ceiling = rig.ceiling;
  const Rigid X_WB = simulator.pose_at(still.begin());
  const Rigid X_LW = ceiling.X_WL.inverse(), X_LB = X_LW * X_WB;

  std::set<int> seen;
  std::vector<int> visible;
  for (int camera = 0; camera < 26; ++camera) {
    simulator.visible(X_WB, camera, visible);
    seen.insert(visible.begin(), visible.end());
  }
  const double width = scale * ceiling.width_m(), height = scale * ceiling.depth_m();
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' font-size='14'>\n"
      "<rect width='100%%' height='100%%' fill='white'/>\n"
      "<text x='%.0f' y='32'>%d LEDs on %d panels of 61 cm, 2.75 m high; the HiBall at 1.45 m</text>\n",
      width + 2 * left, height + top + 76, left, ceiling.beacons(), ceiling.panels());
  std::printf("<path stroke='#ccc' d='");
  for (int k = 0; k <= ceiling.columns; ++k)
    std::printf("M%.1f %.0fv%.1f", left + scale * k * ceiling.panel_m, top, height);
  for (int k = 0; k <= ceiling.rows; ++k)
    std::printf("M%.0f %.1fh%.1f", left, top + scale * k * ceiling.panel_m, width);
  std::printf("'/>\n");
  for (const bool is_seen : {false, true}) {
    std::printf("<path stroke='%s' stroke-width='%s' stroke-linecap='round' d='", is_seen ? "#000" : "#999",
                is_seen ? "4.5" : "2");
    for (std::size_t k = 0; k < rig.beacons_W.size(); ++k) {
      if (seen.contains(static_cast<int>(k)) != is_seen) continue;
      const Vector2 p = on_page(ceiling, X_LW * rig.beacons_W[k]);
      std::printf("M%.1f %.1fh0", p.x(), p.y());
    }
    std::printf("'/>\n");
  }
  for (const HiBallCamera& camera : rig.cameras) draw_field(ceiling, camera, X_LB);
  const Vector2 ball = on_page(ceiling, X_LB.p());
  std::printf("<path d='M%.1f %.1fm-6 0h12m-6 -6v12' stroke='#000' stroke-width='2'/>\n", ball.x(), ball.y());
  const double y = top + height;
  std::printf(
      "<g transform='translate(%.0f %.0f)'><rect y='-12' width='14' height='14' fill='#1a4fb530' stroke='#1a4fb5'/>"
      "<text x='20'>primary views</text><rect x='140' y='-12' width='14' height='14' fill='none' stroke='#b00020'/>"
      "<text x='160'>secondary views</text><circle cx='297' cy='-5' r='2.2'/><text x='306'>LED that a view sees</text>"
      "<text y='26'>cross: below it is the HiBall, here tilted by 5 deg</text></g>\n</svg>\n",
      left, y + 28);
}
