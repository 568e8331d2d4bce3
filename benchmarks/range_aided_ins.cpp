// The Constellation tracker's two steps beside the textbook's: a strapdown integrator that carries its covariance densely
// with each reading, and corrects it by a range with dense matrices in Joseph's form. Both take the same second of readings at
// 500 Hz and ranges of 8 beacons at 3 receivers.
//   build/bench/bin/bench_range_aided_ins
//   valgrind --tool=callgrind --toggle-collect='*reading_step*' build/bench/bin/bench_range_aided_ins --count
#include <cstring>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/motion/head_motions.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/simulation/ultrasonic_ranging.hpp>
#include <holdfast/tracking/range_aided_ins.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

/// 15 numbers of error, everything dense.
class TextbookIns {
 public:
  TextbookIns(const ConstellationRig& rig, const Rigid& X_WB) : rig_(rig) {
    state_.X_WS = X_WB;
    state_.gravity_W = -standard_gravity * Vector3::UnitY();
    P_.setIdentity();
    P_ *= 1e-4;
  }

  void update(const InertialReading& reading) {
    constexpr double dt = 0.002;
    const Vector3 rate = reading.rate_B - state_.bias.rate_B, force = reading.force_B - state_.bias.force_B;
    StrapdownIncrement step;
    step.seconds = dt;
    step.q = so3::exp<double>(dt * rate);
    step.velocity_B = so3::exp<double>(0.5 * dt * rate) * (dt * force);
    step.position_B = 0.5 * dt * step.velocity_B;
    const StrapdownCovariance F = strapdown_transition(step, state_.X_WS.R());
    StrapdownCovariance Q = StrapdownCovariance::Zero();
    add_noise(Q, dt, state_.X_WS.R(), noise_);
    P_ = F * P_ * F.transpose() + Q;
    state_.move(step);
  }

  void update(const BeaconRange& range) {
    const Vector3& lever = rig_.receivers[static_cast<std::size_t>(range.receiver)].p_B;
    const Matrix3 R = state_.X_WS.R();
    const Vector3 apart = state_.X_WS * lever - rig_.beacons[static_cast<std::size_t>(range.beacon)].p_W;
    MatrixOf<double, 1, 15> H = MatrixOf<double, 1, 15>::Zero();
    H.leftCols<3>() = apart.normalized().transpose();
    H.middleCols<3>(3) = -apart.normalized().transpose() * R * so3::hat<double>(lever);
    const double variance = (H * P_ * H.transpose())(0, 0) + 4e-6;
    const VectorOf<double, 15> K = P_ * H.transpose() / variance;
    const StrapdownCovariance keep = StrapdownCovariance::Identity() - K * H;
    P_ = keep * P_ * keep.transpose() + 4e-6 * K * K.transpose();
    InertialState::Error d = InertialState::Error::Zero();
    d.head<15>() = K * (range.range_m - apart.norm());
    state_.add(d);
  }

  [[nodiscard]] const InertialState& state() const { return state_; }

 private:
  ConstellationRig rig_;
  InertialState state_;
  StrapdownCovariance P_;
  StrapdownNoise noise_{Vector3::Constant(2e-4), Vector3::Constant(2e-3), Vector3::Constant(5e-5),
                        Vector3::Constant(5e-4)};
};

struct Second {
  std::unique_ptr<Motion> motion = make_rotation(1, 4s);
  ConstellationRig rig{bench_constellation(), head_receivers()};
  std::vector<InertialReading> readings = inertial_stream(*motion, mems_inertial_unit());
  std::vector<SimulatedRange> ranges = ultrasonic_stream(*motion, rig, UltrasonicDevices(rig, table_1_errors()));

  [[nodiscard]] RangeAidedIns tracker() const {
    RangeAidedIns started(rig.beacons, rig.receivers);
    started.start({motion->begin(), motion->at(motion->begin()).X_WB}, {0.001, 0.001});
    return started;
  }
};

// Steps that callgrind can tell apart.
__attribute__((noinline)) void reading_step(RangeAidedIns& tracker, const InertialReading& reading) {
  tracker.update(reading);
}
__attribute__((noinline)) void range_step(RangeAidedIns& tracker, const BeaconRange& range) {
  tracker.update(range);
}
__attribute__((noinline)) void dense_reading_step(TextbookIns& tracker, const InertialReading& reading) {
  tracker.update(reading);
}
__attribute__((noinline)) void dense_range_step(TextbookIns& tracker, const BeaconRange& range) {
  tracker.update(range);
}

/// All readings and ranges in their order. Answers how many of each.
template <typename Tracker, typename Reading, typename Range>
std::pair<long, long> play(const Second& second, Tracker& tracker, const Reading& read, const Range& hear) {
  std::size_t next = 0;
  for (const InertialReading& reading : second.readings) {
    for (; next < second.ranges.size() && second.ranges[next].range.t < reading.t; ++next) {
      hear(tracker, second.ranges[next].range);
    }
    read(tracker, reading);
  }
  return {static_cast<long>(second.readings.size()), static_cast<long>(next)};
}

/// Time per step, by the step that is not left out.
template <bool Reads, typename Make, typename Reading, typename Range>
void time_steps(benchmark::State& state, const Make& make, const Reading& read, const Range& hear) {
  const Second second;
  using Clock = std::chrono::steady_clock;
  for (auto _ : state) {
    auto tracker = make(second);
    Clock::duration spent{};
    const auto timed = [&](const auto& step) {
      return [&](auto& asked, const auto& input) {
        const Clock::time_point begin = Clock::now();
        step(asked, input);
        spent += Clock::now() - begin;
      };
    };
    std::pair<long, long> counts;
    if constexpr (Reads) {
      counts = play(second, tracker, timed(read), hear);
    } else {
      counts = play(second, tracker, read, timed(hear));
    }
    benchmark::DoNotOptimize(tracker);
    state.SetIterationTime(std::chrono::duration<double>(spent).count() /
                           static_cast<double>(Reads ? counts.first : counts.second));
  }
}

const auto ours = [](const Second& second) { return second.tracker(); };
const auto textbook = [](const Second& second) {
  return TextbookIns(second.rig, second.motion->at(second.motion->begin()).X_WB);
};

void reading_of_ours(benchmark::State& state) {
  time_steps<true>(state, ours, reading_step, range_step);
}
void range_of_ours(benchmark::State& state) {
  time_steps<false>(state, ours, reading_step, range_step);
}
void reading_of_textbook(benchmark::State& state) {
  time_steps<true>(state, textbook, dense_reading_step, dense_range_step);
}
void range_of_textbook(benchmark::State& state) {
  time_steps<false>(state, textbook, dense_reading_step, dense_range_step);
}

void estimate_with_covariance(benchmark::State& state) {
  const Second second;
  RangeAidedIns tracker = second.tracker();
  play(second, tracker, reading_step, range_step);
  for (auto _ : state) benchmark::DoNotOptimize(tracker.estimate());
}

BENCHMARK(reading_of_ours)->UseManualTime()->Iterations(20);
BENCHMARK(reading_of_textbook)->UseManualTime()->Iterations(20);
BENCHMARK(range_of_ours)->UseManualTime()->Iterations(20);
BENCHMARK(range_of_textbook)->UseManualTime()->Iterations(20);
BENCHMARK(estimate_with_covariance);

}  // namespace

/// --count: each step once for each reading and range, for callgrind.
int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "--count") == 0) {
    const Second second;
    RangeAidedIns tracker = second.tracker();
    TextbookIns dense = textbook(second);
    const auto counts = play(second, tracker, reading_step, range_step);
    play(second, dense, dense_reading_step, dense_range_step);
    std::printf("%ld readings, %ld ranges; apart by %.1f mm at the end\n", counts.first, counts.second,
                1e3 * (tracker.pose().X_WB.p() - dense.state().X_WS.p()).norm());
    return 0;
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
