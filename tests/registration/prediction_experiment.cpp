// 001's figure 6 with our motions, and evaluation.md's values 10 to 13 of the inertial predictor as published.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/registration/prediction_experiment.hpp>
#include <holdfast/tracking/pose_filter.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

constexpr Duration interval = 60ms;

/// Figure 6 of 001: mean and peak of angle (deg), position (mm), screen (px), of none, without and with inertial sensors.
struct Published {
  const char* motion;
  double mean[3][3], peak[3][3];
};
constexpr Published published[]{{"M4",
                                 {{1.3, 14.3, 9.3}, {0.2, 2.5, 4.5}, {0.1, 1.1, 2.7}},
                                 {{4.3, 38.0, 62.0}, {0.8, 9.0, 26.7}, {0.4, 6.1, 15.1}}},
                                {"M5",
                                 {{2.2, 6.6, 33.6}, {0.6, 3.3, 13.6}, {0.18, 1.6, 5.2}},
                                 {{5.3, 17.6, 92.1}, {1.6, 11.7, 51.0}, {0.57, 9.8, 36.1}}},
                                {"M6",
                                 {{2.5, 17.8, 37.1}, {0.6, 5.2, 16.2}, {0.2, 2.7, 7.2}},
                                 {{6.5, 46.0, 118.6}, {1.8, 17.1, 62.8}, {0.7, 17.8, 30.1}}}};

AzumaBishopSettings told(const InertialUnit& unit) {
  AzumaBishopSettings settings;
  settings.accelerometers_S = unit.accelerometers_S;
  return settings;
}

/// The Kalman filter of our own that has no inertial sensors, told the poses' noise: a fairer rival than 001's settings.
PredictionErrors own_without(const Motion& motion, const SensedMotion& sensed, const PoseNoise& noise) {
  PoseFilterSettings settings;
  settings.noise = noise;
  PoseFilter<3> filter(head_model(), settings);
  return prediction_errors(
      motion, sensed,
      [&](const TimedPose& pose, auto, HostTime t) {
        filter.update(pose);
        return predict_state(filter.state(), filter.model(), t).X_WB;
      },
      interval);
}

void print_row(const char* name, const PredictionErrors& e, const double (&mean)[3], const double (&peak)[3]) {
  std::printf("  %-22s %5.2f %5.2f  %5.1f %5.1f  %5.1f %6.1f   | %5.2f %5.2f  %5.1f %5.1f  %5.1f %6.1f\n", name,
              e.angle_deg.mean, e.angle_deg.peak, e.position_mm.mean, e.position_mm.peak, e.screen_px.mean,
              e.screen_px.peak, mean[0], peak[0], mean[1], peak[1], mean[2], peak[2]);
}

double yaw_deg(const Rigid& X_WB) {
  const Vector3 ahead = X_WB.q() * Vector3(0, 0, -1);
  return radians(std::atan2(-ahead.x(), -ahead.z())).degrees();
}

/// What the inertial predictor says of each moment of a motion.
struct Prediction {
  HostTime t;
  Rigid X_WB;
};
std::vector<Prediction> predictions(const Motion& motion, const SensingSettings& sensing, Duration ahead,
                                    Duration believed) {
  const SensedMotion sensed = sense(motion, sensing);
  AzumaBishopFilter filter(told(sensing.unit));
  std::vector<Prediction> said;
  for (std::size_t i = 0; i < sensed.poses.size(); ++i) {
    filter.update(sensed.poses[i], sensed.readings[i]);
    said.push_back({sensed.poses[i].t + ahead, azuma_bishop_pose(filter.state(), to_seconds(believed))});
  }
  return said;
}

}  // namespace

TEST_CASE("001 figure 6 at 60 ms: none > without > with inertial sensors, 5 times and 2 times, angle and position") {
  std::printf("60 ms ahead, poses every 10 ms with 0.5 mm and 0.05 deg of noise; ours | 001 figure 6\n");
  std::printf("  %-22s %11s  %11s  %12s\n", "", "deg", "mm", "px: mean, peak");
  for (const Published& p : published) {
    const std::unique_ptr<Motion> motion = make_motion(p.motion);
    SensingSettings sensing;
    sensing.noise = {5e-4, degrees(0.05).radians()};
    const SensedMotion sensed = sense(*motion, sensing);
    const Figure6 f = figure_6(*motion, sensed, told(sensing.unit), interval);
    const PredictionErrors own = own_without(*motion, sensed, sensing.noise);
    std::printf(" %s\n", p.motion);
    print_row("none", f.none, p.mean[0], p.peak[0]);
    print_row("without inertial", f.without_inertial, p.mean[1], p.peak[1]);
    print_row("own filter, without", own, p.mean[1], p.peak[1]);
    print_row("with inertial", f.with_inertial, p.mean[2], p.peak[2]);
    const auto ordered = [](const ErrorStatistics& none, const ErrorStatistics& without, const ErrorStatistics& with) {
      CHECK(none.mean > without.mean);
      CHECK(without.mean > 2.0 * with.mean);
      CHECK(none.mean > 5.0 * with.mean);
    };
    for (const PredictionErrors* without : {&f.without_inertial, &own}) {
      ordered(f.none.angle_deg, without->angle_deg, f.with_inertial.angle_deg);
      ordered(f.none.position_mm, without->position_mm, f.with_inertial.position_mm);
      ordered(f.none.screen_px, without->screen_px, f.with_inertial.screen_px);
    }
    // Ours are motions of about the same speed, or the comparison says nothing.
    CHECK(f.none.angle_deg.mean == doctest::Approx(p.mean[0][0]).epsilon(0.15));
    CHECK(f.none.position_mm.mean == doctest::Approx(p.mean[0][1]).epsilon(0.15));
  }
}

TEST_CASE("what a filter is not told about its sensors, it pays for: errors at 60 ms, means of the three motions") {
  using Change = std::function<void(SensingSettings&, AzumaBishopSettings&)>;
  const auto mean = [](const char* name, const Change& change) {
    double deg = 0.0, mm = 0.0;
    for (const char* id : {"M4", "M5", "M6"}) {
      const std::unique_ptr<Motion> motion = make_motion(id);
      SensingSettings sensing;
      sensing.noise = {5e-4, degrees(0.05).radians()};
      AzumaBishopSettings settings = told(sensing.unit);
      change(sensing, settings);
      const PredictionErrors e = figure_6(*motion, sense(*motion, sensing), settings, interval).with_inertial;
      deg += e.angle_deg.mean / 3.0;
      mm += e.position_mm.mean / 3.0;
    }
    std::printf("  %-40s %.3f deg %.2f mm\n", name, deg, mm);
    return std::pair(deg, mm);
  };
  const auto gyros = [](double deg_s) {
    return Change([=](auto& s, auto&) { s.unit.gyro.bias.setConstant(degrees(deg_s).radians()); });
  };
  const auto accelerometers = [](double mg) {
    return Change([=](auto& s, auto&) { s.unit.accelerometer.bias.setConstant(1e-3 * mg * standard_gravity); });
  };
  const auto turned = [](double deg) {
    const Vector3 turn = degrees(deg).radians() / std::sqrt(3.0) * Vector3::Ones();
    return Change([=](auto&, auto& s) { s.X_BS = Rigid::rotation(so3::exp<double>(turn)); });
  };
  const auto told_all = mean("nothing is wrong", [](auto&, auto&) {});
  const auto off = mean("gyros off by 1 deg/s each", gyros(1.0));
  const auto pushed = mean("accelerometers off by 10 mg each", accelerometers(10.0));
  const auto pushed_more = mean("accelerometers off by 30 mg each", accelerometers(30.0));
  const auto askew = mean("unit turned by 1 deg", turned(1.0)), more_askew = mean("unit turned by 5 deg", turned(5.0));
  const auto late = mean("readings late by one pose", [](auto& s, auto&) { s.unit.lag = 10ms; });
  const auto apart = mean("accelerometers' places", [](auto&, auto& s) { s.accelerometers_S.fill(Vector3::Zero()); });
  CHECK(off.first > 1.2 * told_all.first);
  CHECK(off.second == doctest::Approx(told_all.second).epsilon(0.02));  // gyros hardly touch the position
  CHECK(pushed.second > 1.5 * told_all.second);
  CHECK(pushed_more.second > 2.0 * pushed.second);
  CHECK(askew.second > 1.5 * told_all.second);
  CHECK(more_askew.second > 3.0 * askew.second);
  CHECK(late.first > 1.3 * told_all.first);
  CHECK(apart.second > 1.5 * told_all.second);
}

// evaluation.md, value 12. The filter smooths a noisy tracker, so at short intervals only a quiet one is quieter than it.
TEST_CASE("head still: the inertial predictor jitters more the farther it predicts, and more than a quiet tracker") {
  const std::unique_ptr<Motion> still = make_still(6s);
  for (const double noise_deg : {0.01, 0.05}) {
    SensingSettings sensing;
    sensing.noise.orientation_rad = degrees(noise_deg).radians();
    std::array<double, 4> jitter{};
    const std::array<Duration, 4> intervals{0ms, 60ms, 100ms, 200ms};
    for (std::size_t k = 0; k < intervals.size(); ++k) {
      double squares = 0.0;
      std::size_t count = 0;
      for (const Prediction& p : predictions(*still, sensing, intervals[k], intervals[k])) {
        if (p.t < time_at(1.0)) continue;
        squares += so3::log<double>(p.X_WB.q()).squaredNorm();
        ++count;
      }
      jitter[k] = radians(std::sqrt(squares / static_cast<double>(count))).arcmin();
    }
    const double tracker = degrees(std::sqrt(3.0) * noise_deg).arcmin();
    MESSAGE("tracker " << tracker << " arcmin; filtered and carried over 0, 60, 100, 200 ms: " << jitter[0] << ", "
                       << jitter[1] << ", " << jitter[2] << ", " << jitter[3]);
    CHECK(jitter[0] < jitter[1]);
    CHECK(jitter[1] < jitter[2]);
    CHECK(jitter[2] < jitter[3]);
    CHECK(jitter[noise_deg < 0.02 ? 1 : 3] > tracker);
  }
}

// evaluation.md, value 11.
TEST_CASE("a ramp that stops: no prediction lags, the inertial predictor overshoots") {
  const std::unique_ptr<Motion> ramp = make_motion("M3");
  SensingSettings sensing;
  sensing.noise = {0.0, 0.0};
  double overshoot = -1e9, lag = 0.0;
  for (const Prediction& p : predictions(*ramp, sensing, interval, interval)) {
    if (p.t < time_at(1.0)) continue;
    overshoot = std::max(overshoot, yaw_deg(p.X_WB) - 20.0);
    lag = std::min(lag, yaw_deg(ramp->at(p.t - interval).X_WB) - 20.0);
  }
  MESSAGE("overshoot " << overshoot << " deg, without prediction " << lag);
  CHECK(lag == doctest::Approx(-6.0).epsilon(0.01));  // 100 deg/s for 60 ms
  CHECK(overshoot > 3.0);
}

// evaluation.md, value 10: what a wrong interval does is what a late or early display does.
TEST_CASE("an interval that is wrong by +-10 ms gives 10 ms of error either way") {
  const std::unique_ptr<Motion> yaw =
      make_yaw_sine(0.5, degrees(15.0), 6s);  // slow: the predictor itself is near exact
  SensingSettings sensing;
  sensing.noise = {0.0, 0.0};
  std::array<double, 3> lead_ms{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Duration believed = interval + 10ms * (static_cast<int>(k) - 1);
    double product = 0.0, squares = 0.0;  // least squares: error = lead * rate
    for (const Prediction& p : predictions(*yaw, sensing, interval, believed)) {
      if (p.t < time_at(1.0) || p.t > yaw->end()) continue;
      const MotionState truth = yaw->at(p.t);
      const double rate = truth.w_WB_B.y();
      product += rate * (degrees(yaw_deg(p.X_WB)) - degrees(yaw_deg(truth.X_WB))).radians();
      squares += rate * rate;
    }
    lead_ms[k] = 1e3 * product / squares;
  }
  MESSAGE("displayed ahead of the head by " << lead_ms[0] << ", " << lead_ms[1] << ", " << lead_ms[2] << " ms");
  CHECK(std::abs(lead_ms[1]) < 1.5);  // of the filter itself, whose angular acceleration lags
  CHECK(std::abs(lead_ms[0] - lead_ms[1] + 10.0) < 0.5);
  CHECK(std::abs(lead_ms[2] - lead_ms[1] - 10.0) < 0.5);
}
