#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/prediction/prediction_distance.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

FramePlanSettings settings_60_hz(Duration believed_A) {
  FramePlanSettings settings;
  settings.display.refresh_hz = 60.0;
  settings.display.first_vsync = time_at(0.005);
  settings.compute_time = believed_A;
  return settings;
}

/// A predictor job whose matrices are ready at `done`.
struct Job {
  FramePlan plan;
  HostTime done;
};

/// A tracker at 83 Hz, a predictor that takes about `A` for each pose, and a renderer at 60 Hz, on clocks of their own: at
/// each start it takes the newest matrices.
PredictionDistanceErrors simulate(PredictionDistance& distance, Duration A, double jitter_ms, int poses, bool learns) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<Job> jobs;
  HostTime ready = time_at(0.0);
  for (int i = 0; i < poses; ++i) {
    const HostTime measured = time_at(i / 83.0);
    const HostTime now = std::max(measured + 15ms, ready);
    const Duration took = std::max<Duration>(A + from_milliseconds(jitter_ms * normal(random)), Duration(0));
    jobs.push_back({*distance.plan(measured, now), now + took});
    ready = now + took;
    if (learns) distance.computed(took);
  }
  const DisplayTiming display = settings_60_hz(A).display;
  std::size_t next = 0;
  for (std::int64_t n = 0; next < jobs.size(); ++n) {
    const HostTime start = vsync_at(display, n);
    const Job* newest = nullptr;
    while (next < jobs.size() && jobs[next].done < start) newest = &jobs[next++];
    if (newest) distance.shown(newest->plan, vsync_at(display, n + 1));
  }
  return distance.errors();
}

}  // namespace

TEST_CASE("001 figure 40: a steady A, told: every distance right") {
  PredictionDistance distance(settings_60_hz(4ms));
  const PredictionDistanceErrors errors = simulate(distance, 4ms, 0.0, 5000, false);
  CHECK(errors.frames > 3500);
  CHECK(errors.wrong_share() == 0.0);
  CHECK(errors.rms_ms == 0.0);
}

TEST_CASE(
    "an A that is wrong by 5 ms is learned; not learned, a fifth and more of the distances are wrong by a refresh") {
  PredictionDistance learns(settings_60_hz(9ms)), believes(settings_60_hz(9ms));
  const PredictionDistanceErrors learned = simulate(learns, 4ms, 0.3, 5000, true);
  const PredictionDistanceErrors believed = simulate(believes, 4ms, 0.3, 5000, false);
  MESSAGE("wrong distances: learned " << 100 * learned.wrong_share() << " %, RMS " << learned.rms_ms << " ms; believed "
                                      << 100 * believed.wrong_share() << " %, " << believed.rms_ms << " ms");
  CHECK(std::abs(to_milliseconds(learns.settings().compute_time) - 4.0) < 0.15);  // the median of 64 of 0.3 ms
  CHECK(learned.wrong_share() < 0.04);  // those within the jitter of a starting point, 0.3 of 16.7 ms on either side
  CHECK(believed.wrong_share() > 0.2);
  CHECK(believed.too_short == 0);                                          // what is planned too late comes sooner
  CHECK(learned.peak_ms == doctest::Approx(1000.0 / 60.0).epsilon(1e-6));  // "when wrong, it's wrong by 16.67 ms"
  CHECK(believed.mean_ms > 3.0);
}

TEST_CASE("the quantile is that of the last 64, whatever came before; a negative A is no A; nothing allocates") {
  for (const auto& [quantile, expected] : {std::pair{0.0, 100ms}, {0.5, 132ms}, {1.0, 163ms}}) {
    PredictionDistance distance(settings_60_hz(1ms), quantile);
    CHECK(distance.settings().compute_time == 1ms);
    const std::size_t before = test::allocations();
    for (int i = 0; i < 164; ++i) distance.computed(i * 1ms);
    distance.computed(-5ms);
    distance.shown(*distance.plan(time_at(1.0), time_at(1.01)), time_at(1.05));
    CHECK(test::allocations() == before);  // allocations.cpp checks that it counts
    CHECK(distance.settings().compute_time == expected);
  }
  PredictionDistance one(settings_60_hz(1ms));
  one.computed(7ms);
  CHECK(one.settings().compute_time == 7ms);
}
