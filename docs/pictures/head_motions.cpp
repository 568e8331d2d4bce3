// Draws docs/pictures/head_motions.svg: how fast the head turns in walk-around, rotation and swing (seed 1).
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/head_motions.cpp -o /tmp/head_motions
//     /tmp/head_motions > docs/pictures/head_motions.svg
#include <cstdio>

#include <holdfast/motion/motions.hpp>

using namespace holdfast;

namespace {

constexpr double left = 80, width = 600, panel = 110, space = 24, top = 14, fastest = 150;

void draw(const char* id, const char* title, double figure_6_deg_s, const char* color, int row) {
  const double panel_top = top + row * (panel + space);
  const auto y_of = [&](double deg_s) { return panel_top + panel * (1.0 - deg_s / fastest); };
  for (int deg_s = 0; deg_s <= 120; deg_s += 40) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", left, left + width, y_of(deg_s),
                y_of(deg_s));
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#444'>%d</text>\n", left - 8, y_of(deg_s) + 5, deg_s);
  }
  const auto motion = make_motion(id, 1);
  double sum = 0.0;
  int count = 0;
  std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", color);
  for (HostTime t = motion->begin(); t <= motion->end(); t += std::chrono::milliseconds(20), ++count) {
    const double deg_s = radians(motion->at(t).w_WB_B.norm()).degrees();
    sum += deg_s;
    std::printf("%.1f,%.1f ", left + width * to_seconds(t - motion->begin()) / to_seconds(motion->duration()),
                y_of(deg_s));
  }
  std::printf("'/>\n<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#888' stroke-dasharray='6 4'/>\n", left,
              left + width, y_of(figure_6_deg_s), y_of(figure_6_deg_s));
  std::printf(
      "<text x='%.0f' y='%.1f' fill='%s'>%s: mean %.0f deg/s; dashed: %.0f deg/s, the mean of figure 6</text>\n",
      left + 8, panel_top + 10, color, title, sum / count, figure_6_deg_s);
}

}  // namespace

int main() {
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 720 460' font-family='sans-serif' font-size='14'>\n"
      "<rect width='720' height='460' fill='white'/>\n");
  draw("M4", "walk-around", 1.3 / 0.06, "#00695c", 0);
  draw("M5", "rotation", 2.2 / 0.06, "#1a4fb5", 1);
  draw("M6", "swing", 2.5 / 0.06, "#b00020", 2);
  for (int s = 0; s <= 10; s += 2) {
    std::printf("<text x='%.0f' y='%.0f' text-anchor='middle' fill='#444'>%d</text>\n", left + width * s / 10.0, 422.0,
                s);
  }
  std::printf(
      "<text x='380' y='446' text-anchor='middle' fill='#444'>time (s)</text>\n"
      "<text x='20' y='205' text-anchor='middle' fill='#444' transform='rotate(-90 20 205)'>angular speed "
      "(deg/s)</text>\n</svg>\n");
}
