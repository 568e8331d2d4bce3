// One SCAAT update with a beacon's calibration (15 states, 2 numbers measured) against a textbook's dense filter of the same
// size (tests/tracking/dense_ekf.hpp), on the same sightings. Before it measures it checks that both agree.
//   build/bench/bin/bench_scaat_update
//   build/bench/bin/bench_scaat_update --updates scaat|engine|joint|dense N     just N updates, for scripts/count-instructions
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <benchmark/benchmark.h>
#include <tracking/dense_ekf.hpp>

#include <holdfast/tracking/joint_filter.hpp>

#include "scaat_setting.hpp"

using namespace holdfast;
using namespace holdfast::benchmarks;

namespace {

// What an engine calls: the assembled filter with its gate, counters and table of devices.
template <typename Filter>
class Engine {
 public:
  void update() {
    const std::size_t k = static_cast<std::size_t>(i_++ % round_length);
    filter_.update(HostTime(std::chrono::milliseconds(i_)), setting().sightings[k], {beacons_, setting().seen[k]});
  }
  [[nodiscard]] const TargetState<2>& state() const { return filter_.state(); }
  [[nodiscard]] std::uint64_t updated() const { return filter_.counters()[UpdateStatus::updated]; }

 private:
  DeviceTable<3> beacons_ = setting().table();
  Filter filter_{Setting::start(), Setting::model(), [] {
                   ScaatSettings open;
                   open.gate.probability = 1.0;  // as the dense filter has none; it is judged all the same
                   return open;
                 }()};
  std::int64_t i_ = 0;
};

using Plain = Engine<ScaatFilter<2>>;
using Joint = Engine<JointFilter<2, 3>>;

class Dense {
 public:
  Dense() {
    filter_.state = Setting::start();
    filter_.P.topLeftCorner<12, 12>() = filter_.state.P;
  }
  void update() {
    const std::size_t k = static_cast<std::size_t>(i_++ % round_length);
    DeviceEstimate<3> beacon = beacons_.for_sighting(setting().seen[k]);
    filter_.update(HostTime(std::chrono::milliseconds(i_)), model_, setting().sightings[k], beacon);
    beacons_.store(setting().seen[k], beacon);
  }
  [[nodiscard]] const TargetState<2>& state() const { return filter_.state; }

 private:
  DeviceTable<3> beacons_ = setting().table();
  test::DenseEkf filter_;
  PvModel model_ = Setting::model();
  std::int64_t i_ = 0;
};

template <typename Filter>
void updates(benchmark::State& state) {
  Filter filter;
  for (auto _ : state) {
    filter.update();
    benchmark::DoNotOptimize(filter.state().P.data());
  }
}
BENCHMARK(updates<Scaat>)->Name("scaat_update");
BENCHMARK(updates<Plain>)->Name("engine_update");
BENCHMARK(updates<Joint>)->Name("joint_update");
BENCHMARK(updates<Dense>)->Name("dense_update");

// Whether all say the same after 100,000 updates, to 1e-7 m, and all were taken.
bool agree() {
  Scaat scaat;
  Plain engine;
  Dense dense;
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    scaat.update();
    engine.update();
    dense.update();
    for (const TargetState<2>* state : {&scaat.state(), &engine.state()}) {
      worst = std::max(worst, (state->X_WB.p() - dense.state().X_WB.p()).norm());
    }
  }
  std::printf("largest difference in 100000 updates: %.1e m (may be 1e-7)\n", worst);
  return worst < 1e-7 && scaat.updated() == 100000 && engine.updated() == 100000;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && std::string_view(argv[1]) == "--updates") {
    const int count = std::atoi(argv[3]);
    const std::string_view which = argv[2];
    if (which == "dense") return only_update<Dense>(count);
    if (which == "joint") return only_update<Joint>(count);
    return which == "engine" ? only_update<Plain>(count) : only_update<Scaat>(count);
  }
  if (!agree()) return 1;
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
