// Chain lookup of nine transforms against tf2::BufferCore (ROS's transform library), the same chain in the same run.
//
// The chain is eq. 6.4 of Robinett & Holloway 1994 (course 11), made rigid because tf2 knows no scale: S US N E H HS TB
// R W O, with HS_TB at 1000 Hz and R_W and W_O at 90 Hz dynamic and the other six static. Every lookup asks for a time
// between samples, so that both interpolate three times. Both are told frames and edges alike and must agree before
// anything is timed.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/frames/frames.hpp>

#include "tf2_chain.hpp"

namespace {

using namespace holdfast;

constexpr std::array<const char*, 10> names{"S", "US", "N", "E", "H", "HS", "TB", "R", "W", "O"};
constexpr double start_s = 100.0;  // tf2 takes time 0 for "the latest"
constexpr double length_s = 2.0;   // of history in either library
constexpr std::size_t questions = 256;

double rate_hz(std::size_t edge) {  // 0: static
  if (edge == 5) return 1000.0;     // T_HS_TB
  return edge >= 7 ? 90.0 : 0.0;    // T_R_W, T_W_O
}

/// T_AB of edge i (A = names[i], B = names[i + 1]) at a time: smooth, different for each edge.
Rigid edge_transform(std::size_t i, double t) {
  const double k = 1.0 + static_cast<double>(i);
  const Vector3 turn(0.3 * std::sin(1.1 * t + k), 0.4 * std::cos(0.9 * t * k), 0.2 * k);
  const Vector3 p(0.1 * k, 0.05 * std::sin(2.0 * t + k), -0.2 + 0.03 * std::cos(t));
  return Rigid(so3::exp<double>(turn), p);
}

std::vector<double> sample_times(std::size_t edge) {
  const double hz = rate_hz(edge);
  if (hz == 0.0) return {start_s};
  std::vector<double> times;
  for (double t = start_s; t <= start_s + length_s; t += 1.0 / hz) times.push_back(t);
  return times;
}

/// Both libraries filled with the same chain, and the times to ask.
struct Chains {
  FrameGraph graph;
  FrameId S, O;
  Tf2Chain tf2{"S", "O"};
  std::vector<HostTime> times;

  Chains() {
    for (std::size_t i = 9; i-- > 0;) add_edge(i);  // the world's side first: the tree hangs from W in both
    S = graph.frame("S");
    O = graph.frame("O");
    ask();
    check_agreement();
  }

  /// In tf2 a frame hangs from one parent. W is the top, so O hangs by T_WO and every other frame by its inverse T_BA;
  /// the graph gets the same, because interpolating an inverse is not inverting an interpolation.
  void add_edge(std::size_t i) {
    const bool below_W = i == 8, dynamic = rate_hz(i) > 0.0;
    const std::string parent = names[below_W ? i : i + 1], child = names[below_W ? i + 1 : i];
    const auto X_parent_child = [&](double t) {
      return below_W ? edge_transform(i, t) : edge_transform(i, t).inverse();
    };
    const FrameId P = graph.frame(parent), C = graph.frame(child);
    const AddedEdge edge =
        dynamic ? graph.add_dynamic(P, C, {.capacity = 4096}) : graph.add_static(P, C, X_parent_child(start_s));
    for (const double t : sample_times(i)) {
      const Rigid X = X_parent_child(t);
      if (dynamic) graph.push(edge.edge, time_at(t), X);
      tf2.set(parent, child, nanoseconds(time_at(t)),
              {X.p().x(), X.p().y(), X.p().z(), X.q().w(), X.q().x(), X.q().y(), X.q().z()}, !dynamic);
    }
  }

  static std::int64_t nanoseconds(HostTime t) { return t.time_since_epoch().count(); }

  /// Times in the newest 30 ms that every dynamic transform has, none of them a sample's own.
  void ask() {
    for (std::size_t k = 0; k < questions; ++k) {
      const double back_s = 0.0123 + 0.0300 * static_cast<double>((k * 97) % questions) / questions;
      times.push_back(time_at(start_s + length_s - back_s + 1.7e-5));
      tf2.add_question(nanoseconds(times.back()));
    }
  }

  void check_agreement() {
    const Chain chain = graph.chain(S, O);
    for (std::size_t k = 0; k < questions; ++k) {
      const RigidNumbers theirs = tf2.ask(k);
      const Quaternion q(theirs.qw, theirs.qx, theirs.qy, theirs.qz);
      const Vector3 p(theirs.px, theirs.py, theirs.pz);
      for (const Lookup& ours : {graph.lookup(S, O, times[k]), chain.at(times[k])}) {
        const double metres = (ours.T_AB.v() - p).norm(), radians = so3::angle_between<double>(ours.T_AB.q(), q);
        // tf2's slerp takes acos of the dot product, which loses half the digits for the small steps here: 1e-8 either
        // way.
        if (ours.status == LookupStatus::ok && metres < 1e-7 && radians < 1e-7) continue;
        std::fprintf(stderr, "tf2 and the graph disagree at question %zu: %s, %g m, %g rad\n", k,
                     to_string(ours.status), metres, radians);
        std::abort();
      }
    }
  }
};

Chains& chains() {
  static Chains both;
  return both;
}

/// One question for each call, asked `repeats` times in a row: 1 is a new time at every lookup, 16 is a frame of two
/// eyes and eight objects, whose 16 lookups have one time.
void tf2_buffer_core(benchmark::State& state) {
  const Chains& c = chains();
  const std::size_t repeats = static_cast<std::size_t>(state.range(0));
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(c.tf2.ask(k++ / repeats % questions));
}

void graph_lookup(benchmark::State& state) {
  const Chains& c = chains();
  const std::size_t repeats = static_cast<std::size_t>(state.range(0));
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(c.graph.lookup(c.S, c.O, c.times[k++ / repeats % questions]));
}

void chain_at(benchmark::State& state) {
  const Chains& c = chains();
  const Chain chain = c.graph.chain(c.S, c.O);
  const std::size_t repeats = static_cast<std::size_t>(state.range(0));
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(chain.at(c.times[k++ / repeats % questions]));
}

template <typename Question>
double seconds_of(Question question) {
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < questions; ++k) question(k);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The three in turn, 256 lookups each, so that whatever else the machine does meets all alike; one iteration is all of
/// them.
void tf2_over_holdfast(benchmark::State& state) {
  const Chains& c = chains();
  const Chain chain = c.graph.chain(c.S, c.O);
  double tf2_s = 0, lookup_s = 0, chain_s = 0;
  for (auto _ : state) {
    tf2_s += seconds_of([&](std::size_t k) { benchmark::DoNotOptimize(c.tf2.ask(k)); });
    lookup_s += seconds_of([&](std::size_t k) { benchmark::DoNotOptimize(c.graph.lookup(c.S, c.O, c.times[k])); });
    chain_s += seconds_of([&](std::size_t k) { benchmark::DoNotOptimize(chain.at(c.times[k])); });
  }
  state.counters["times_faster_lookup"] = tf2_s / lookup_s;
  state.counters["times_faster_chain"] = tf2_s / chain_s;
}

BENCHMARK(tf2_buffer_core)->Arg(1)->Arg(16);
BENCHMARK(graph_lookup)->Arg(1)->Arg(16);
BENCHMARK(chain_at)->Arg(1)->Arg(16);
BENCHMARK(tf2_over_holdfast);

}  // namespace
