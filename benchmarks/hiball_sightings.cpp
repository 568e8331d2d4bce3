// How fast sightings are simulated: a walk-around of ten seconds, one sighting a millisecond, in each order.
#include <benchmark/benchmark.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/simulation/simulation.hpp>

using namespace holdfast;

namespace {

void stream(benchmark::State& state, SightingOrder order, bool secondary_views) {
  const auto walk = make_walk_around(1, std::chrono::seconds(10));
  const SplineTrajectory truth = hiball_truth(place_under_ceiling(sample(*walk, std::chrono::milliseconds(10))));
  HiBallOptions options;
  options.secondary_views = secondary_views;
  const HiBallSimulator simulator(hiball_rig(options), truth);
  std::size_t sightings = 0;
  for (auto _ : state) sightings += sighting_stream(simulator, {.order = order}).size();
  state.counters["sightings/s"] = benchmark::Counter(static_cast<double>(sightings), benchmark::Counter::kIsRate);
}

}  // namespace

BENCHMARK_CAPTURE(stream, round_robin_6_views, SightingOrder::round_robin, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream, random_6_views, SightingOrder::random, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream, least_recently_used_6_views, SightingOrder::least_recently_used, false)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stream, least_recently_used_26_views, SightingOrder::least_recently_used, true)
    ->Unit(benchmark::kMillisecond);
