// Draws docs/pictures/swim.svg: a head that shakes, what a display 60 ms late shows of it, the error and the swim.
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/swim.cpp -o /tmp/swim
//     /tmp/swim > docs/pictures/swim.svg
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/experiment.hpp>

using namespace holdfast;

namespace {

struct Series {
  std::string name, color;
  std::vector<Vector2> points;  // s and the panel's unit
};

/// A strip of the chart with its own scale, zero in the middle.
struct Panel {
  double top, height, most;
  std::string title;
  std::vector<double> ticks;
};

constexpr double left = 64, width = 560, begin_s = 0.5, end_s = 1.5;

double x_of(double t) {
  return left + width * (t - begin_s) / (end_s - begin_s);
}

void draw(const Panel& panel, const std::vector<Series>& series) {
  const auto y_of = [&](double v) { return panel.top + panel.height * (0.5 - 0.5 * v / panel.most); };
  std::printf("<text x='%.0f' y='%.0f' font-weight='bold'>%s</text>\n", left, panel.top - 10, panel.title.c_str());
  for (const double tick : panel.ticks) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='%s'/>\n", left, left + width, y_of(tick),
                y_of(tick), tick == 0.0 ? "#888" : "#ddd");
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#555'>%g</text>\n", left - 8, y_of(tick) + 4, tick);
  }
  for (const Series& s : series) {
    std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", s.color.c_str());
    for (const Vector2& p : s.points) std::printf("%.1f,%.1f ", x_of(p.x()), y_of(p.y()));
    std::printf("'/>\n");
  }
}

struct Run {
  Series yaw, error, swim;
};

Run run(Pipeline pipeline, const char* name, const char* color, Series& truth) {
  ExperimentSettings settings;
  settings.pipeline = pipeline;
  const auto motion = make_motion("M1", 1);
  Run result{{name, color, {}}, {name, color, {}}, {name, color, {}}};
  truth.points.clear();
  std::optional<Vector2> last;
  const auto observe = [&](const FrameRecord& frame) {
    const double t = to_seconds(frame.t_display.time_since_epoch());
    if (t < begin_s || t > end_s) return;
    const auto yaw_deg = [](const Rigid& X) { return so3::log<double>(X.q()).y() * degrees_per_rad; };
    truth.points.emplace_back(t, yaw_deg(frame.X_WH_true));
    result.yaw.points.emplace_back(t, yaw_deg(frame.X_WH_displayed));
    const Vector2 error_px = frame.fiducials[6].error_px;  // the disc straight ahead at 2 m
    result.error.points.emplace_back(t, error_px.x());
    const double error_deg = frame.fiducials[6].error_rad.x() * degrees_per_rad;
    if (last) result.swim.points.emplace_back(0.5 * (t + last->x()), (error_deg - last->y()) / (t - last->x()));
    last = Vector2(t, error_deg);
  };
  if (run_experiment(*motion, settings, default_registration_scene(), observe).status != ExperimentStatus::ok)
    std::abort();
  return result;
}

}  // namespace

int main() {
  Series truth{"the head", "#222", {}};
  const Run held = run(Pipeline::p0, "P0, no prediction", "#d1495b", truth);
  const Run predicted = run(Pipeline::p1, "P1, constant velocity", "#00798c", truth);
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 660 610' font-family='sans-serif' font-size='13'>\n");
  std::printf("<rect width='660' height='610' fill='white'/>\n");
  draw({58, 132, 4.0, "Where the head looks, and where the picture was drawn for (deg)", {-3, 0, 3}},
       {truth, held.yaw, predicted.yaw});
  draw({240, 140, 60.0, "Error of the disc at 2 m: virtual less real (px)", {-50, -25, 0, 25, 50}},
       {held.error, predicted.error});
  draw({430, 120, 35.0, "Swim: how fast that error changes (deg/s)", {-30, -15, 0, 15, 30}},
       {held.swim, predicted.swim});
  double x = left;
  for (const auto& [name, color] : {std::pair{truth.name, truth.color}, std::pair{held.yaw.name, held.yaw.color},
                                    std::pair{predicted.yaw.name, predicted.yaw.color}}) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='17' y2='17' stroke='%s' stroke-width='3'/>\n", x, x + 24, color.c_str());
    std::printf("<text x='%.0f' y='21'>%s</text>\n", x + 30, name.c_str());
    x += 60.0 + 7.5 * static_cast<double>(name.size());
  }
  for (double t = begin_s; t <= end_s + 1e-9; t += 0.25) {
    std::printf("<text x='%.0f' y='574' text-anchor='middle' fill='#555'>%g s</text>\n", x_of(t), t);
  }
  std::printf(
      "<text x='%.0f' y='598' fill='#555'>Yaw 2 Hz +-3 deg, latency 60 ms, 90 Hz, 1280 x 720, left eye.</text>\n",
      left);
  std::printf("</svg>\n");
}
