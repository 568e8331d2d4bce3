// Draws docs/pictures/inertial_prediction.svg: 001's figure 7, and what its appendix D says of jitter, with our motion M5.
//     g++ -std=c++20 -O2 -Iinclude -I/usr/include/eigen3 docs/pictures/inertial_prediction.cpp -o /tmp/inertial_prediction
//     /tmp/inertial_prediction > docs/pictures/inertial_prediction.svg
// The table goes to the error output.
#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include <holdfast/motion/generators.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
#include <holdfast/prediction/jitter.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/registration/prediction_experiment.hpp>
#include <holdfast/tracking/pose_filter.hpp>

using namespace holdfast;

namespace {

constexpr std::array names{"none", "without inertial sensors, 001", "without, PoseFilter", "with inertial sensors, 001",
                           "with, InertialPredictor"};
constexpr std::array colors{"#b00020", "#e08030", "#1a4fb5", "#00695c", "#7b1fa2"};
constexpr std::array intervals_ms{25, 40, 60, 80, 100, 125, 150, 175, 200};

/// All methods on one motion, at one interval.
class Methods {
 public:
  Methods(const SensingSettings& sensing, Duration interval) : interval_(interval) {
    AzumaBishopSettings settings;
    settings.accelerometers_S = sensing.unit.accelerometers_S;
    without_ = with_ = AzumaBishopFilter(settings);
    PoseFilterSettings poses;
    poses.noise = sensing.noise;
    poses_ = PoseFilter<3>(head_model(), poses);
    InertialPredictorSettings own;
    own.limits.future = std::chrono::seconds(1);
    own.poses.noise = sensing.noise;
    own_ = InertialPredictor(own);
  }

  [[nodiscard]] std::array<Rigid, 5> at(const TimedPose& pose, std::span<const InertialReading> readings) {
    for (const InertialReading& reading : readings) own_.update(reading);
    without_.update(pose);
    with_.update(pose, readings.back());
    poses_.update(pose);
    own_.update(pose);
    const double seconds = to_seconds(interval_);
    const HostTime t = pose.t + interval_;
    return {pose.X_WB, azuma_bishop_pose(without_.state(), seconds),
            predict_state(poses_.state(), poses_.model(), t, {std::chrono::seconds(1), {}}).X_WB,
            azuma_bishop_pose(with_.state(), seconds), own_.predict(t).X_WB};
  }

 private:
  Duration interval_;
  AzumaBishopFilter without_, with_;
  PoseFilter<3> poses_{head_model()};
  InertialPredictor own_;
};

/// Of one method at one interval.
struct Point {
  PredictionErrors errors;
  double jitter_arcmin = 0.0;
};

std::array<Point, 5> evaluate(const char* name, Duration interval) {
  const auto motion = make_motion(name);
  SensingSettings sensing;
  sensing.noise = {5e-4, degrees(0.05).radians()};
  sensing.unit = azuma_bishop_inertial_unit(std::chrono::milliseconds(2));
  sensing.unit.accelerometers_S.fill(Vector3::Zero());  // a triad, which InertialPredictor expects
  const SensedMotion sensed = sense(*motion, sensing);
  std::array<Point, 5> points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    Methods methods(sensing, interval);
    std::vector<Vector3> turned;
    points[k].errors = prediction_errors(
        *motion, sensed,
        [&](const TimedPose& pose, std::span<const InertialReading> readings, HostTime t) {
          const Rigid X_WB = methods.at(pose, readings)[k];
          if (pose.t > time_at(1.0)) turned.push_back(so3::log<double>(motion->at(t).X_WB.q().conjugate() * X_WB.q()));
          return X_WB;
        },
        interval);
    points[k].jitter_arcmin = radians(band_rms<3>(turned, 100.0).value()).arcmin();
  }
  return points;
}

constexpr double top = 40, height = 280, width = 330;

template <typename Value>
void panel(double left, const char* title, const char* unit, double highest, double step,
           const std::vector<std::array<Point, 5>>& rows, const Value& value) {
  const auto x_of = [&](double ms) { return left + width * ms / 200.0; };
  const auto y_of = [&](double v) { return top + height * (1.0 - v / highest); };
  std::printf("<text x='%.0f' y='%.0f' text-anchor='middle' fill='#222'>%s</text>\n", left + width / 2, top - 14,
              title);
  for (double v = 0.0; v <= highest; v += step) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", left, left + width, y_of(v),
                y_of(v));
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#444'>%g</text>\n", left - 6, y_of(v) + 5, v);
  }
  for (int ms = 0; ms <= 200; ms += 50) {
    std::printf("<text x='%.1f' y='%.0f' text-anchor='middle' fill='#444'>%d</text>\n", x_of(ms), top + height + 20,
                ms);
  }
  std::printf("<text x='%.0f' y='%.0f' text-anchor='middle' fill='#444'>prediction interval, ms</text>\n",
              left + width / 2, top + height + 40);
  std::printf("<text x='%.0f' y='%.0f' text-anchor='middle' fill='#444' transform='rotate(-90 %.0f %.0f)'>%s</text>\n",
              left - 42, top + height / 2, left - 42, top + height / 2, unit);
  for (std::size_t k = 0; k < names.size(); ++k) {
    std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", colors[k]);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (value(rows[i][k]) <= highest) std::printf("%.1f,%.1f ", x_of(intervals_ms[i]), y_of(value(rows[i][k])));
    }
    std::printf("'/>\n");
  }
}

}  // namespace

int main() {
  for (const char* motion : {"M4", "M5", "M6"}) {
    std::fprintf(stderr, "%s at 60 ms: mean deg, mm, px of 512 over 30 deg; 3 to 12 Hz arcmin\n", motion);
    const std::array<Point, 5> points = evaluate(motion, std::chrono::milliseconds(60));
    for (std::size_t k = 0; k < names.size(); ++k) {
      const PredictionErrors& e = points[k].errors;
      std::fprintf(stderr, "  %-30s %6.3f %6.2f %6.2f %6.2f\n", names[k], e.angle_deg.mean, e.position_mm.mean,
                   e.screen_px.mean, points[k].jitter_arcmin);
    }
  }
  std::vector<std::array<Point, 5>> rows;
  for (const int ms : intervals_ms) rows.push_back(evaluate("M5", std::chrono::milliseconds(ms)));
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 860 440' font-family='sans-serif' font-size='14'>\n"
      "<rect width='860' height='440' fill='white'/>\n");
  panel(70, "Rotation: mean error on the screen (001 figure 7)", "px", 100, 25, rows,
        [](const Point& p) { return p.errors.screen_px.mean; });
  panel(500, "Jitter: error from 3 to 12 Hz (001 appendix D)", "arcmin", 40, 10, rows,
        [](const Point& p) { return p.jitter_arcmin; });
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double x = 70.0 + 270.0 * static_cast<double>(k % 3), y = k < 3 ? 398.0 : 422.0;
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.0f' y2='%.0f' stroke='%s' stroke-width='3'/>\n", x, x + 24, y - 5,
                y - 5, colors[k]);
    std::printf("<text x='%.0f' y='%.0f' fill='#222'>%s</text>\n", x + 32, y, names[k]);
  }
  std::printf("</svg>\n");
}
