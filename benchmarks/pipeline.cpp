// What a frame costs: exchanging a pose, beginning a frame, latching late, deflecting for both eyes.
// build/bench/bin/bench_pipeline
#include <benchmark/benchmark.h>

#include <holdfast/pipeline/pipeline.hpp>

using namespace holdfast;

namespace {

PoseEstimate estimate(double t) {
  PoseEstimate e;
  e.t = time_at(t);
  e.X_WB = Rigid(so3::exp<double>(Vector3(0.1, 0.3, 0.2)), Vector3(0.1, 1.7, 0.3));
  e.velocity = Twist{Vector3(0.3, 0.1, 0.0), Vector3(0.2, 1.7, 0.1)};
  e.covariance = 1e-6 * Matrix12::Identity();
  return e;
}

HmdModel rolling_hmd() {
  HmdModel hmd = default_hmd();
  hmd.timing.scan_out = ScanOut::rolling;
  hmd.timing.scan_duration = from_milliseconds(11.1);
  return hmd;
}

void publish(benchmark::State& state) {
  LatestPose latest;
  PoseEstimate e = estimate(1.0);
  for (auto _ : state) {
    e.t += Duration(1);
    benchmark::DoNotOptimize(latest.publish(e));
  }
}
BENCHMARK(publish);

void newest(benchmark::State& state) {
  LatestPose latest;
  latest.publish(estimate(1.0));
  for (auto _ : state) benchmark::DoNotOptimize(latest.newest());
}
BENCHMARK(newest);

void begin_frame(benchmark::State& state) {
  LatestPose latest;
  latest.publish(estimate(1.0));
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  for (auto _ : state) benchmark::DoNotOptimize(loop.begin_frame(time_at(1.002)));
}
BENCHMARK(begin_frame);

void late_latch(benchmark::State& state) {
  LatestPose latest;
  latest.publish(estimate(1.0));
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  Frame frame = loop.begin_frame(time_at(1.002));
  for (auto _ : state) benchmark::DoNotOptimize(loop.late_latch(frame, time_at(1.01)));
}
BENCHMARK(late_latch);

void deflect_both_eyes(benchmark::State& state) {
  LatestPose latest;
  latest.publish(estimate(1.0));
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  const Frame frame = loop.begin_frame(time_at(1.002));
  latest.publish(estimate(1.01));
  for (auto _ : state) benchmark::DoNotOptimize(loop.deflect(frame.rendered_views(), time_at(1.012)));
}
BENCHMARK(deflect_both_eyes);

void observe_vsync(benchmark::State& state) {
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  std::int64_t n = 0;
  for (auto _ : state) benchmark::DoNotOptimize(loop.observe_vsync(vsync_at(rolling_hmd().timing, ++n)));
}
BENCHMARK(observe_vsync);

void prepare(benchmark::State& state) {
  LatestPose latest;
  const LatestPoseSource source(latest);
  const HmdModel hmd = rolling_hmd();
  for (auto _ : state) benchmark::DoNotOptimize(FrameLoop(hmd, source));
}
BENCHMARK(prepare)->Unit(benchmark::kMicrosecond);

}  // namespace
