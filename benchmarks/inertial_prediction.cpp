// A prediction with covariance by InertialPredictor, beside the textbook's: F P F^T of the filter's 22 numbers, dense, with the pose
// at constant velocity and acceleration. Both from the same filter, after the same second of motion.
//   build/bench/bin/bench_inertial_prediction
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

struct Followed {
  std::unique_ptr<Motion> motion = make_motion("M5");
  std::vector<InertialReading> readings = inertial_stream(*motion, mems_inertial_unit());
  InertialPredictor head;
  std::size_t next = 0;
  HostTime t = motion->begin();

  Followed() {
    while (t < motion->begin() + 1s) step();
  }
  void step() {
    for (; next < readings.size() && readings[next].t <= t; ++next) head.update(readings[next]);
    head.update(TimedPose{t, motion->at(t).X_WB});
    t += 10ms;
  }
};

void predict_with_covariance(benchmark::State& state) {
  const Followed followed;
  const HostTime now = followed.head.filter().now().t;
  std::int64_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(followed.head.predict(now + 20ms + std::chrono::microseconds(i++ % 40000)));
}

void textbook_prediction(benchmark::State& state) {
  const Followed followed;
  const InertialFilter& filter = followed.head.filter();
  const InertialState& now = filter.now();
  const Vector3 w = filter.history().newest().rate_B - now.bias.rate_B, a = filter.acceleration_now_W();
  std::int64_t i = 0;
  for (auto _ : state) {
    const double T = 0.02 + 1e-6 * static_cast<double>(i++ % 40000);
    using S = InertialState;
    S::Covariance F = S::Covariance::Identity();
    F.block<3, 3>(S::place, S::velocity) = T * Matrix3::Identity();
    F.block<3, 3>(S::place, S::gravity) = 0.5 * T * T * Matrix3::Identity();
    F.block<3, 3>(S::place, S::force_bias) = -0.5 * T * T * now.X_WS.R();
    F.block<3, 3>(S::turn, S::turn) = so3::exp<double>(-T * w).toRotationMatrix();
    F.block<3, 3>(S::turn, S::rate_bias) = -T * so3::right_jacobian<double>(T * w);
    const S::Covariance P = F * filter.covariance() * F.transpose();
    const Rigid X(now.X_WS.q() * so3::exp<double>(T * w), now.X_WS.p() + T * now.v_WS + 0.5 * T * T * a);
    benchmark::DoNotOptimize(P);
    benchmark::DoNotOptimize(X);
  }
}

/// Ten milliseconds of readings at 500 Hz and a pose, with all that is learnt from it.
void update_for_10_ms(benchmark::State& state) {
  auto followed = std::make_unique<Followed>();
  for (auto _ : state) {
    if (followed->t + 100ms > followed->motion->end()) {
      state.PauseTiming();
      followed = std::make_unique<Followed>();
      state.ResumeTiming();
    }
    followed->step();
  }
}

BENCHMARK(predict_with_covariance);
BENCHMARK(textbook_prediction);
BENCHMARK(update_for_10_ms);

}  // namespace
