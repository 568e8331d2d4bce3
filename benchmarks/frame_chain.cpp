// Chain lookup of nine transforms against tf2::BufferCore (ROS's transform library), the same chains in the same run.
//
// The chain is eq. 6.4 of Robinett & Holloway 1994 (course 11), made rigid because tf2 knows no scale: S US N E H HS TB
// R W O, with HS_TB at 1000 Hz and R_W and W_O at 90 Hz dynamic and the other six static. It is there for two eyes and
// eight objects: 16 chains. Every lookup asks for a time between samples, so that three transforms are interpolated.
//   frame:    the 16 chains of one display time, then the 16 of another: what a renderer asks for each frame
//   new_time: one chain at another time at every lookup: nothing remembered from a lookup before can serve
// Both libraries must agree on all 16 chains before anything is timed.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/frames/frames.hpp>

#include "tf2_chain.hpp"

namespace {

using namespace holdfast;

constexpr std::array<const char*, 10> names{"S", "US", "N", "E", "H", "HS", "TB", "R", "W", "O"};
constexpr std::size_t eyes = 2, objects = 8, chains_per_frame = eyes * objects;
constexpr double start_s = 100.0;  // tf2 takes time 0 for "the latest"
constexpr double length_s = 2.0;   // of history in either library
constexpr std::size_t times_asked = 256;

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

/// Frames left of H are there once for each eye, O once for each object.
std::string frame_name(std::size_t i, std::size_t eye, std::size_t object) {
  if (i <= 3) return names[i] + std::to_string(eye);
  return i == 9 ? names[i] + std::to_string(object) : names[i];
}

/// Both libraries filled with the same chains, and the times to ask.
struct Chains {
  FrameGraph graph;
  Tf2Chain tf2;
  std::vector<FrameId> S, O;
  std::vector<Chain> resolved;
  std::vector<HostTime> times;

  Chains() {
    graph.frame("W");
    for (std::size_t i = 9; i-- > 0;) {
      const std::size_t copies = i <= 3 ? eyes : i == 8 ? objects : 1;
      for (std::size_t copy = 0; copy < copies; ++copy) add_edge(i, copy);
    }
    for (std::size_t eye = 0; eye < eyes; ++eye) S.push_back(graph.frame(frame_name(0, eye, 0)));
    for (std::size_t object = 0; object < objects; ++object) O.push_back(graph.frame(frame_name(9, 0, object)));
    for (std::size_t c = 0; c < chains_per_frame; ++c) {
      resolved.push_back(graph.chain(S[c % eyes], O[c / eyes]));
      tf2.add_chain(frame_name(0, c % eyes, 0), frame_name(9, 0, c / eyes));
    }
    choose_times();
    check_agreement();
  }

  /// In tf2 a frame hangs from one parent. W is the top, so O hangs by T_WO and every other frame by its inverse T_BA;
  /// the graph gets the same, because interpolating an inverse is not inverting an interpolation.
  void add_edge(std::size_t i, std::size_t copy) {
    const bool below_W = i == 8, dynamic = rate_hz(i) > 0.0;
    const std::string A = frame_name(i, copy, copy), B = frame_name(i + 1, copy, copy);
    const std::string parent = below_W ? A : B, child = below_W ? B : A;
    const auto X_parent_child = [&](double t) {
      const Rigid X = Rigid::translation(Vector3(0.1 * static_cast<double>(copy), 0, 0)) * edge_transform(i, t);
      return below_W ? X : X.inverse();
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

  /// Times in the newest 42 ms that every dynamic transform has, none of them a sample's own.
  void choose_times() {
    for (std::size_t k = 0; k < times_asked; ++k) {
      const double back_s = 0.0123 + 0.0300 * static_cast<double>((k * 97) % times_asked) / times_asked;
      times.push_back(time_at(start_s + length_s - back_s + 1.7e-5));
      tf2.add_time(nanoseconds(times.back()));
    }
  }

  [[nodiscard]] Lookup lookup(std::size_t k, std::size_t c) const {
    return graph.lookup(S[c % eyes], O[c / eyes], times[k]);
  }

  void check_agreement() const {
    for (std::size_t k = 0; k < times_asked; ++k) {
      for (std::size_t c = 0; c < chains_per_frame; ++c) {
        const RigidNumbers theirs = tf2.ask(k, c);
        check_same(theirs, lookup(k, c));
        check_same(theirs, resolved[c].at(times[k]));
      }
    }
  }

  static void check_same(const RigidNumbers& theirs, const Lookup& ours) {
    const Quaternion q(theirs.qw, theirs.qx, theirs.qy, theirs.qz);
    const Vector3 p(theirs.px, theirs.py, theirs.pz);
    const double metres = (ours.T_AB.v() - p).norm(), radians = so3::angle_between<double>(ours.T_AB.q(), q);
    // tf2's slerp takes acos of the dot product, which loses half the digits for steps as small as these: 1e-8.
    if (ours.status == LookupStatus::ok && metres < 1e-7 && radians < 1e-7) return;
    std::fprintf(stderr, "tf2 and the graph disagree: %s, %g m, %g rad\n", to_string(ours.status), metres, radians);
    std::abort();
  }
};

Chains& chains() {
  static Chains both;
  return both;
}

/// Lookup n of a run: its time and its chain.
struct Question {
  std::size_t time, chain;
};
Question of_frame(std::size_t n) {
  return {n / chains_per_frame % times_asked, n % chains_per_frame};
}
Question of_new_time(std::size_t n) {
  return {n % times_asked, 0};
}

RigidNumbers ask_tf2(Question q) {
  return chains().tf2.ask(q.time, q.chain);
}
Lookup ask_lookup(Question q) {
  return chains().lookup(q.time, q.chain);
}
Lookup ask_chain(Question q) {
  return chains().resolved[q.chain].at(chains().times[q.time]);
}

template <auto Ask, auto Order>
void one_lookup(benchmark::State& state) {
  std::size_t n = 0;
  for (auto _ : state) benchmark::DoNotOptimize(Ask(Order(n++)));
}

/// Of this thread's own processor time, so that other programs do not count.
double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <auto Ask, auto Order>
double seconds_of_a_round() {
  const double begin = processor_seconds();
  for (std::size_t n = 0; n < times_asked * chains_per_frame; ++n) benchmark::DoNotOptimize(Ask(Order(n)));
  return processor_seconds() - begin;
}

/// The three in turn, 4096 lookups each, so that whatever else the machine does meets all alike.
template <auto Order>
void tf2_over_holdfast(benchmark::State& state) {
  double tf2_s = 0, lookup_s = 0, chain_s = 0;
  for (auto _ : state) {
    tf2_s += seconds_of_a_round<ask_tf2, Order>();
    lookup_s += seconds_of_a_round<ask_lookup, Order>();
    chain_s += seconds_of_a_round<ask_chain, Order>();
  }
  state.counters["times_faster_lookup"] = tf2_s / lookup_s;
  state.counters["times_faster_chain"] = tf2_s / chain_s;
}

BENCHMARK(one_lookup<ask_tf2, of_frame>)->Name("frame/tf2_buffer_core");
BENCHMARK(one_lookup<ask_lookup, of_frame>)->Name("frame/graph_lookup");
BENCHMARK(one_lookup<ask_chain, of_frame>)->Name("frame/chain_at");
BENCHMARK(tf2_over_holdfast<of_frame>)->Name("frame/tf2_over_holdfast")->Unit(benchmark::kMillisecond);
BENCHMARK(one_lookup<ask_tf2, of_new_time>)->Name("new_time/tf2_buffer_core");
BENCHMARK(one_lookup<ask_lookup, of_new_time>)->Name("new_time/graph_lookup");
BENCHMARK(one_lookup<ask_chain, of_new_time>)->Name("new_time/chain_at");
BENCHMARK(tf2_over_holdfast<of_new_time>)->Name("new_time/tf2_over_holdfast")->Unit(benchmark::kMillisecond);

}  // namespace
