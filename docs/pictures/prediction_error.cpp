// Draws docs/pictures/prediction_error.svg: error of predictors on sines, theory as lines, our predictors as dots.
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/prediction_error.cpp -o /tmp/prediction_error
//     /tmp/prediction_error > docs/pictures/prediction_error.svg
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <holdfast/motion/motions.hpp>
#include <holdfast/prediction/prediction.hpp>

using namespace holdfast;

namespace {

constexpr double left = 80, top = 20, width = 600, height = 330, f_T_max = 0.5, highest = 3.5;

double x_of(double f_T) {
  return left + width * f_T / f_T_max;
}
double y_of(double error) {
  return top + height * (1.0 - error / highest);
}

void curve(theory::Order order, const char* color, const char* name, int row) {
  std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", color);
  for (int i = 0; i <= 200; ++i) {
    const double f_T = f_T_max * i / 200, error = theory::error(order, f_T, 1.0);
    if (error <= highest) std::printf("%.1f,%.1f ", x_of(f_T), y_of(error));
  }
  const double y = top + 24 + 22 * row;
  std::printf("'/>\n<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='%s' stroke-width='3'/>\n", left + 20,
              left + 50, y - 5, y - 5, color);
  std::printf("<text x='%.0f' y='%.1f' fill='%s'>%s</text>\n", left + 60, y, color, name);
}

/// Greatest error of a predictor that is given the exact state of a small yaw sine, over the amplitude.
double measured(Predictor predictor, double hz) {
  const double amplitude = 0.001;
  const auto motion = make_yaw_sine(hz, radians(amplitude), std::chrono::seconds(20));
  double worst = 0.0;
  for (int i = 0; i < 500; ++i) {
    const MotionState s = motion->at(time_at(1.0 + i / 500.0 / hz));
    PoseEstimate estimate;
    estimate.t = s.t;
    estimate.X_WB = s.X_WB;
    estimate.velocity = Twist{s.v_WB, s.w_WB_B};
    const PredictionResult r = predict(predictor, estimate, s.t + std::chrono::milliseconds(60));
    worst = std::max(worst, so3::angle_between<double>(r.X_WB.q(), motion->at(r.t).X_WB.q()));
  }
  return worst / amplitude;
}

void dots(Predictor predictor, const char* color) {
  for (double hz = 0.5; hz < 8.0; hz += 0.5) {
    const double error = measured(predictor, hz);
    if (error <= highest)
      std::printf("<circle cx='%.1f' cy='%.1f' r='4' fill='%s'/>\n", x_of(hz * 0.06), y_of(error), color);
  }
}

}  // namespace

int main() {
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 720 430' font-family='sans-serif' font-size='14'>\n"
      "<rect width='720' height='430' fill='white'/>\n");
  for (int i = 0; i <= 3; ++i) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", left, left + width, y_of(i),
                y_of(i));
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#444'>%d</text>\n", left - 8, y_of(i) + 5, i);
  }
  for (int i = 0; i <= 5; ++i) {
    const double x = x_of(0.1 * i);
    std::printf("<line x1='%.1f' x2='%.1f' y1='%.0f' y2='%.0f' stroke='#ddd'/>\n", x, x, top, top + height);
    std::printf("<text x='%.1f' y='%.0f' text-anchor='middle' fill='#444'>%.1f</text>\n", x, top + height + 20,
                0.1 * i);
  }
  std::printf(
      "<text x='380' y='396' text-anchor='middle' fill='#444'>frequency times interval, f T (0.3 at 60 ms is 5 "
      "Hz)</text>\n"
      "<text x='24' y='185' text-anchor='middle' fill='#444' transform='rotate(-90 24 185)'>error / "
      "amplitude</text>\n");
  curve(theory::Order::none, "#b00020", "none", 0);
  curve(theory::Order::constant_velocity, "#1a4fb5", "constant velocity: worse than none above 0.302", 1);
  curve(theory::Order::constant_acceleration, "#00695c", "constant acceleration: worse than none above 0.365", 2);
  dots(Predictor::none, "#b00020");
  dots(Predictor::constant_velocity, "#1a4fb5");
  std::printf(
      "<text x='%.0f' y='418' text-anchor='middle' fill='#666'>lines: theory; dots: our predictors at 60 "
      "ms</text>\n</svg>\n",
      left + width / 2);
}
