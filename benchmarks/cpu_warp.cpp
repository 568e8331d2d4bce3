// The CPU warp (lens and rolling homography computed on the fly, bilinear, 8 bits) against cv::remap on the same picture.
// OpenCV is given the map ready-made: as two float planes, as pairs of floats, and in its own fixed-point form. Each
// round times all of them one after another, so that what else the machine does meets all alike; the counters hold the
// fastest round of each. The pictures that come out are compared first: OpenCV rounds positions to 1/32 px.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <holdfast/deflection/cpu_warp.hpp>
#include <holdfast/deflection/deflect.hpp>

namespace {

using namespace holdfast;

struct Setup {
  EyeModel eye;
  DisplayTiming timing;
  RenderedView view;
  ScanHomography H_SE;

  /// The Flight Helmet's lens on a panel of this size; the head turns at 200 deg/s and is shown 11 ms later, by rows.
  Setup(int width, int height, bool per_color) {
    eye.tangents = {-0.82, 0.51, -0.5, 0.5};
    eye.resolution = {width, height};
    const double unit = 1.19 / 2 / 1.18;
    eye.lens = Lens(RadialLens{0.1933}, {Vector2::Zero(), Vector2(unit, unit)});
    if (per_color) {
      eye.lens_red = Lens(RadialLens{0.1853}, {Vector2::Zero(), Vector2(unit, unit)});
      eye.lens_blue = Lens(RadialLens{0.2053}, {Vector2::Zero(), Vector2(unit, unit)});
    }
    timing.scan_out = ScanOut::rolling;
    timing.scan_duration = from_milliseconds(11.1);
    // As much wider as the lens shows, with the panel's density: source and target have the same size.
    view.tangents = {-1.05, 0.61, -0.62, 0.62};
    view.size = {width, height};
    const auto turned = [](double ms) {
      return Rigid(so3::exp<double>(Vector3(0.05, 0.2, 0.02) * (3.5 * ms * 1e-3)), Vector3::Zero());
    };
    const DeflectionResult result = deflect({}, view, {turned(11.0), turned(22.1)});
    H_SE = result.H_SE;
  }
  [[nodiscard]] ComposedWarp warp(LensMode mode) const { return {eye, mode, timing, view, H_SE}; }
};

/// Noise, blurred so that neighbours differ by less than 20/255: rounding positions to 1/32 px then hardly shows.
cv::Mat smooth_picture(int width, int height) {
  cv::Mat picture(height, width, CV_8UC4);
  cv::theRNG().state = 1;
  cv::randu(picture, 0, 255);
  cv::GaussianBlur(picture, picture, {0, 0}, 2.5);
  cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX);
  return picture;
}

template <typename Channel>
PictureSpan<Channel> span(cv::Mat& picture) {
  return {picture.ptr<Channel>(), picture.cols, picture.rows,
          static_cast<std::ptrdiff_t>(picture.step / sizeof(Channel))};
}

/// The map as OpenCV wants it: texels, pairs of floats; far outside where there is no source.
cv::Mat exact_map(const ComposedWarp& warp) {
  const PixelSize size = warp.eye().resolution;
  cv::Mat map(size.height, size.width, CV_32FC2);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto p = warp.source_pixel(Vector2(x + 0.5, y + 0.5));
      map.at<cv::Vec2f>(y, x) =
          p ? cv::Vec2f(static_cast<float>(p->x() - 0.5), static_cast<float>(p->y() - 0.5)) : cv::Vec2f(-1e4F, -1e4F);
    }
  }
  return map;
}

/// Greatest difference where all neighbours are within the source.
int greatest_difference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& map, int margin) {
  int worst = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const auto p = map.at<cv::Vec2f>(y, x);
      const auto m = static_cast<float>(margin);
      if (p[0] < m || p[1] < m || p[0] > static_cast<float>(a.cols) - 1.0F - m ||
          p[1] > static_cast<float>(a.rows) - 1.0F - m) {
        continue;
      }
      for (int c = 0; c < 4; ++c) {
        worst = std::max(worst, std::abs(a.at<cv::Vec4b>(y, x)[c] - b.at<cv::Vec4b>(y, x)[c]));
      }
    }
  }
  return worst;
}

/// What others do on the machine only ever slows: the fastest round tells what the work costs.
double fastest(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

template <typename Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void against_remap(benchmark::State& state, WarpFilter filter, int interpolation) {
  cv::setNumThreads(1);
  const auto width = static_cast<int>(state.range(0));
  const auto height = static_cast<int>(state.range(1));
  const Setup setup(width, height, false);
  const ComposedWarp warp = setup.warp(LensMode::exact);
  const WarpLattice lattice(setup.eye, LensMode::exact);
  CpuWarp one({1, filter});
  CpuWarp two({2, filter});
  cv::Mat source = smooth_picture(width, height);
  cv::Mat ours(height, width, CV_8UC4), theirs(height, width, CV_8UC4);
  const cv::Mat pairs = exact_map(warp);
  std::array<cv::Mat, 2> planes;
  cv::split(pairs, planes.data());
  cv::Mat fixed, fraction;
  cv::convertMaps(planes[0], planes[1], fixed, fraction, CV_16SC2);
  const auto draw = [&](CpuWarp& with) {
    with.draw(lattice, warp, span<const std::uint8_t>(source), span<std::uint8_t>(ours));
  };
  const auto remap = [&](const cv::Mat& a, const cv::Mat& b) {
    cv::remap(source, theirs, a, b, interpolation, cv::BORDER_CONSTANT);
  };
  draw(one);
  remap(planes[0], planes[1]);
  const int difference = greatest_difference(ours, theirs, pairs, filter == WarpFilter::bilinear ? 0 : 2);
  if (difference > 3) {
    state.SkipWithError(("the pictures differ by " + std::to_string(difference) + "/255").c_str());
    return;
  }
  std::array<std::vector<double>, 5> times;
  for (auto _ : state) {
    times[0].push_back(seconds([&] { draw(one); }));
    times[1].push_back(seconds([&] { draw(two); }));
    times[2].push_back(seconds([&] { remap(planes[0], planes[1]); }));
    times[3].push_back(seconds([&] { remap(pairs, cv::Mat()); }));
    times[4].push_back(seconds([&] { remap(fixed, fraction); }));
    state.SetIterationTime(times[0].back());
  }
  const auto ms = [&](std::size_t i) { return 1e3 * fastest(times[i]); };
  state.counters["ours_ms"] = ms(0);
  state.counters["two_threads_ms"] = ms(1);
  state.counters["remap_planes_ms"] = ms(2);
  state.counters["remap_pairs_ms"] = ms(3);
  state.counters["remap_fixed_ms"] = ms(4);
  state.counters["faster_than_remap"] = std::min(ms(2), ms(3)) / ms(0);
  state.counters["faster_than_fixed"] = ms(4) / ms(0);
  state.counters["two_threads_gain"] = ms(0) / ms(1);
  state.counters["difference_255"] = difference;
}
BENCHMARK_CAPTURE(against_remap, bilinear, WarpFilter::bilinear, cv::INTER_LINEAR)
    ->Args({1280, 720})
    ->Args({2160, 2160})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(against_remap, bicubic, WarpFilter::bicubic, cv::INTER_CUBIC)
    ->Args({1280, 720})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

enum class Way { lens, no_lens, per_color, portable };

/// The other ways through the warp, on one core.
template <typename Channel>
void alone(benchmark::State& state, Way way, WarpFilter filter) {
  const Setup setup(1280, 720, way == Way::per_color);
  const LensMode mode = way == Way::no_lens ? LensMode::none : LensMode::exact;
  const ComposedWarp warp = setup.warp(mode);
  const WarpLattice lattice(setup.eye, mode);
  CpuWarp cpu({1, filter, way != Way::portable});
  cv::Mat source = smooth_picture(1280, 720);
  if (sizeof(Channel) == 4) source.convertTo(source, CV_32FC4, 1.0 / 255.0);
  cv::Mat target = source.clone();
  for (auto _ : state) {
    cpu.draw(lattice, warp, span<const Channel>(source), span<Channel>(target));
    benchmark::ClobberMemory();
  }
}
void bytes(benchmark::State& state, Way way, WarpFilter filter) {
  alone<std::uint8_t>(state, way, filter);
}
void floats(benchmark::State& state, Way way, WarpFilter filter) {
  alone<float>(state, way, filter);
}
constexpr benchmark::TimeUnit ms = benchmark::kMillisecond;
BENCHMARK_CAPTURE(bytes, bilinear, Way::lens, WarpFilter::bilinear)->Unit(ms);
BENCHMARK_CAPTURE(bytes, bilinear_no_lens, Way::no_lens, WarpFilter::bilinear)->Unit(ms);
BENCHMARK_CAPTURE(bytes, bilinear_per_color, Way::per_color, WarpFilter::bilinear)->Unit(ms);
BENCHMARK_CAPTURE(bytes, bilinear_portable, Way::portable, WarpFilter::bilinear)->Unit(ms);
BENCHMARK_CAPTURE(bytes, bicubic, Way::lens, WarpFilter::bicubic)->Unit(ms);
BENCHMARK_CAPTURE(floats, bilinear, Way::lens, WarpFilter::bilinear)->Unit(ms);
BENCHMARK_CAPTURE(floats, bicubic, Way::lens, WarpFilter::bicubic)->Unit(ms);

/// Preparing a lens, once an eye.
void prepare_lattice(benchmark::State& state) {
  const Setup setup(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), false);
  for (auto _ : state) benchmark::DoNotOptimize(WarpLattice(setup.eye, LensMode::exact).bytes());
}
BENCHMARK(prepare_lattice)->Args({1280, 720})->Args({2160, 2160})->Unit(ms);

}  // namespace
