// Exact inverse of the radial lens per point, against cv::undistortPoints on the same lens (Brown's k1 alone) and the
// same points. OpenCV iterates a fixed point: with its default criteria (5 steps) it leaves pixels, so it is also timed
// with the criteria that bring it to our accuracy. `residual_px` is the worst |distort(undistort(v)) - v| over the
// points, at 481 px per unit of tangent. The other models follow, each on real parameters (tests/optics/published_lenses)
// and the same points, cut down to its domain; the first is RadialLens behind the class Lens, with its placement.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include <holdfast/optics/lens.hpp>

#include "../tests/optics/published_lenses.hpp"

namespace {

using namespace holdfast;

constexpr double px_per_tangent = 481.0;  // the Flight Helmet's
constexpr int side = 100;

/// The Flight Helmet's lens: k = 0.1933 at half the picture's height.
const RadialLens lens{0.1933};
constexpr double r_norm = 1.19 / 2 / 1.18;

/// A grid over the picture that is predistorted, in units of r_norm: the Flight Helmet's paraxial field of 66 by 53 degrees.
std::vector<Vector2> seen_points() {
  std::vector<Vector2> points;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      points.push_back(Vector2(-0.82 + 1.33 * i / (side - 1), -0.504 + 1.008 * j / (side - 1)) / r_norm);
    }
  }
  return points;
}

double worst_residual_px(const std::vector<Vector2>& seen, const std::vector<Vector2>& panel) {
  double worst = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    worst = std::max(worst, (panel[i] * (1.0 + lens.k * panel[i].squaredNorm()) - seen[i]).norm());
  }
  return worst * r_norm * px_per_tangent;
}

void report(benchmark::State& state, const std::vector<Vector2>& seen, const std::vector<Vector2>& panel) {
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * static_cast<std::int64_t>(seen.size()));
  state.counters["per_point"] = benchmark::Counter(
      static_cast<double>(seen.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["residual_px"] = worst_residual_px(seen, panel);
}

void holdfast_exact(benchmark::State& state) {
  const std::vector<Vector2> seen = seen_points();
  std::vector<Vector2> panel(seen.size());
  for (auto _ : state) {
    for (std::size_t i = 0; i < seen.size(); ++i) panel[i] = *lens.undistort(seen[i]);
    benchmark::DoNotOptimize(panel.data());
    benchmark::ClobberMemory();
  }
  report(state, seen, panel);
}
BENCHMARK(holdfast_exact);

/// Any model's inverse, over the points scaled into the disc that it covers (at most 1.2 tangents).
void model_inverse(benchmark::State& state, const test::PublishedLens& published) {
  const Lens& of_model = published.lens;
  std::vector<Vector2> seen = seen_points();
  double farthest = 0.0;
  for (const Vector2& v : seen) farthest = std::max(farthest, v.norm());
  for (Vector2& v : seen) v = of_model.centre() + v * (std::min(1.2, published.seen_radius) / farthest);
  std::vector<Vector2> panel(seen.size());
  for (auto _ : state) {
    for (std::size_t i = 0; i < seen.size(); ++i) panel[i] = *of_model.undistort(seen[i]);
    benchmark::DoNotOptimize(panel.data());
    benchmark::ClobberMemory();
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) worst = std::max(worst, (*of_model.distort(panel[i]) - seen[i]).norm());
  state.counters["per_point"] = benchmark::Counter(
      static_cast<double>(seen.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["residual_px"] = worst * px_per_tangent;
}
const bool models_registered = [] {
  for (const test::PublishedLens& published : test::published_lenses()) {
    benchmark::RegisterBenchmark(("lens: " + published.name).c_str(), model_inverse, published);
  }
  return true;
}();

void opencv(benchmark::State& state, const cv::TermCriteria& criteria) {
  const std::vector<Vector2> seen = seen_points();
  std::vector<cv::Point2d> points;
  for (const Vector2& p : seen) points.emplace_back(p.x(), p.y());
  std::vector<cv::Point2d> out(points.size());
  const cv::Matx33d camera = cv::Matx33d::eye();
  const cv::Vec4d k1(lens.k, 0.0, 0.0, 0.0);
  for (auto _ : state) {
    cv::undistortPoints(points, out, camera, k1, cv::noArray(), cv::noArray(), criteria);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  std::vector<Vector2> panel;
  for (const cv::Point2d& p : out) panel.emplace_back(p.x, p.y);
  report(state, seen, panel);
}
// OpenCV's own default.
BENCHMARK_CAPTURE(opencv, default_5_steps, cv::TermCriteria(cv::TermCriteria::MAX_ITER, 5, 0.01));
BENCHMARK_CAPTURE(opencv, steps_20, cv::TermCriteria(cv::TermCriteria::MAX_ITER, 20, 0.0));
// As accurate as ours.
BENCHMARK_CAPTURE(opencv, steps_60, cv::TermCriteria(cv::TermCriteria::MAX_ITER, 60, 0.0));
BENCHMARK_CAPTURE(opencv, to_1e_9, cv::TermCriteria(cv::TermCriteria::MAX_ITER | cv::TermCriteria::EPS, 200, 1e-9));

}  // namespace
