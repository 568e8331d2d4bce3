#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/frames/graph.hpp>

using namespace holdfast;

namespace {

Vqs random_transform(std::mt19937_64& random) {
  std::normal_distribution<double> n;
  const Vector3 turn(n(random), n(random), n(random));
  return Vqs(Vector3(n(random), n(random), n(random)), so3::exp<double>(turn), std::exp(0.3 * n(random)));
}

double difference(const Vqs& a, const Vqs& b) {
  return (a.v() - b.v()).norm() + so3::angle_between<double>(a.q(), b.q()) + std::abs(std::log(a.s() / b.s()));
}

/// The graph of figure 5.1: two users in one world, each with a room, a head, a hand and two eyes, and three objects.
struct TwoUsers {
  FrameGraph graph;
  std::vector<EdgeId> dynamic;
  FrameId W = graph.frame("W");

  TwoUsers() {
    for (const char* user : {"1", "2"}) {
      const auto named = [&](const char* name) { return graph.frame(std::string(name) + user); };
      add_dynamic(named("R"), W);
      add_dynamic(named("H"), named("R"));
      add_dynamic(named("Hand"), named("R"));
      add_static(named("LE"), named("H"), 0.031);
      add_static(named("RE"), named("H"), -0.031);
    }
    for (const char* object : {"O1", "O2", "O3"}) add_dynamic(W, graph.frame(object));
  }
  void add_dynamic(FrameId A, FrameId B) {
    const AddedEdge added = graph.add_dynamic(A, B);
    REQUIRE(added);
    dynamic.push_back(added.edge);
  }
  void add_static(FrameId A, FrameId B, double x) {
    REQUIRE(graph.add_static(A, B, Rigid::translation(Vector3(x, 0, 0))));
  }
};

}  // namespace

TEST_CASE("a frame is registered once and found by name") {
  FrameGraph graph;
  const FrameId W = graph.frame("W");
  CHECK(graph.frame("W") == W);
  CHECK(graph.frame_count() == 1);
  CHECK(graph.name(W) == "W");
  CHECK(graph.find("W") == W);
  CHECK_FALSE(graph.find("w").has_value());
  CHECK(graph.frame_count() == 1);
  CHECK_FALSE(FrameId().valid());
}

TEST_CASE("T_AB of an edge, its inverse, and a frame with itself") {
  FrameGraph graph;
  const FrameId A = graph.frame("A"), B = graph.frame("B");
  const Vqs T_AB(Vector3(1, 2, 3), so3::exp<double>(Vector3(0.1, 0.2, 0.3)), 2.0);
  REQUIRE(graph.add_static(A, B, T_AB));
  CHECK(difference(graph.lookup(A, B, time_at(0)).T_AB, T_AB) < 1e-14);
  CHECK(difference(graph.lookup(B, A, time_at(0)).T_AB, T_AB.inverse()) < 1e-14);
  CHECK(difference(graph.lookup(B, B, time_at(0)).T_AB, Vqs()) < 1e-15);
  CHECK(graph.lookup(A, B, time_at(0)).status == LookupStatus::ok);
}

TEST_CASE("an edge that would close a cycle is refused and both ways are named") {
  FrameGraph graph;
  const FrameId W = graph.frame("W"), R = graph.frame("R"), TB = graph.frame("TB"), H = graph.frame("H");
  REQUIRE(graph.add_dynamic(R, W));
  REQUIRE(graph.add_static(R, TB, Vqs()));
  REQUIRE(graph.add_dynamic(TB, H));
  const std::uint64_t version = graph.version();
  const AddedEdge second = graph.add_static(W, H, Vqs());
  CHECK_FALSE(second);
  CHECK(second.status == EdgeStatus::second_way);
  CHECK(second.message == "W -> R -> TB -> H already connects W and H; the new edge W -> H would be a second way");
  CHECK(graph.add_dynamic(TB, R).message ==
        "TB -> R already connects TB and R; the new edge TB -> R would be a second way");
  CHECK(graph.edges().size() == 3);
  CHECK(graph.version() == version);
}

TEST_CASE("other bad edges are refused by name") {
  FrameGraph graph;
  const FrameId A = graph.frame("A"), B = graph.frame("B");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(graph.add_static(A, A, Vqs()).status == EdgeStatus::same_frame);
  CHECK(graph.add_static(A, FrameId(), Vqs()).status == EdgeStatus::unknown_frame);
  CHECK(graph.add_static(FrameId(7), B, Vqs()).status == EdgeStatus::unknown_frame);
  CHECK(graph.add_static(A, B, Rigid::translation(Vector3(nan, 0, 0))).status == EdgeStatus::not_finite);
  CHECK(graph.edges().empty());
  CHECK(graph.push(EdgeId(), time_at(0), Vqs()) == PushStatus::not_dynamic);
  const AddedEdge fixed = graph.add_static(A, B, Vqs());
  CHECK(graph.push(fixed.edge, time_at(0), Vqs()) == PushStatus::not_dynamic);
  CHECK_FALSE(graph.set_static(fixed.edge, Rigid::translation(Vector3(nan, 0, 0))));
  CHECK(graph.lookup(A, FrameId(), time_at(0)).status == LookupStatus::unknown_frame);
}

TEST_CASE("a lookup between components says so, and which frames each has") {
  FrameGraph graph;
  const FrameId A = graph.frame("A"), B = graph.frame("B"), C = graph.frame("C"), D = graph.frame("D");
  graph.add_static(A, B, Vqs());
  graph.add_static(C, D, Vqs());
  CHECK(graph.lookup(A, D, time_at(0)).status == LookupStatus::no_path);
  CHECK_FALSE(graph.lookup(A, D, time_at(0)));
  CHECK(graph.missing_path(B, C) == "no path between B and C: B is connected with {A, B}, C with {C, D}");
  CHECK(graph.missing_path(A, B).empty());
  CHECK(graph.components().size() == 2);
  graph.add_static(B, C, Vqs());
  CHECK(graph.components().size() == 1);
  CHECK(graph.lookup(A, D, time_at(0)));
}

TEST_CASE("every dependent transform of two users at any time is the product along its path") {
  TwoUsers users;
  std::mt19937_64 random(3);
  for (const EdgeId e : users.dynamic) {
    for (const double t : {0.0, 0.3, 0.7, 1.0}) users.graph.push(e, time_at(t), random_transform(random));
  }
  const std::int32_t n = static_cast<std::int32_t>(users.graph.frame_count());
  for (const double t : {0.1, 0.5, 0.9}) {
    for (std::int32_t a = 0; a < n; ++a) {
      for (std::int32_t b = 0; b < n; ++b) {
        Vqs expected;
        const std::vector<PathStep> path = users.graph.path(FrameId(a), FrameId(b)).value();
        for (const PathStep& step : path) {
          const Vqs T = users.graph.edge(step.edge)->at(time_at(t)).T_AB;
          expected = expected * (step.inverted ? T.inverse() : T);
        }
        const Lookup found = users.graph.lookup(FrameId(a), FrameId(b), time_at(t));
        CHECK(found.status == LookupStatus::ok);
        // Up to six transforms with scales of e^+-1 each: rounding grows to some 1e-14.
        CHECK(difference(found.T_AB, expected) < 1e-12);
      }
    }
  }
}

TEST_CASE("user 2 sees user 1's head: T_RE2_H1, by hand") {
  TwoUsers users;
  FrameGraph& g = users.graph;
  // Rooms: user 1 stands 10 m east of user 2 in the world; heads 1.7 m up, hands do not matter.
  const auto push = [&](const char* A, const char* B, const Vector3& v) {
    const std::vector<PathStep> path = g.path(*g.find(A), *g.find(B)).value();
    REQUIRE(path.size() == 1);
    REQUIRE(g.push(path[0].edge, time_at(0), Rigid::translation(v)) == PushStatus::accepted);
  };
  push("R1", "W", Vector3(-10, 0, 0));
  push("R2", "W", Vector3(0, 0, 0));
  push("H1", "R1", Vector3(0, -1.7, 0));
  push("H2", "R2", Vector3(0, -1.7, 0));
  const Lookup found = g.lookup(*g.find("RE2"), *g.find("H1"), time_at(0));
  REQUIRE(found);
  // H1's origin: (10, 1.7, 0) in W; in H2 (10, 0, 0); T_RE_H shifts by -0.031.
  CHECK((found.T_AB * Vector3::Zero() - Vector3(9.969, 0, 0)).norm() < 1e-14);
}

TEST_CASE("status and oldest age come from the edges on the path and from no other") {
  TwoUsers users;
  FrameGraph& g = users.graph;
  const FrameId Hand1 = *g.find("Hand1"), H1 = *g.find("H1"), LE1 = *g.find("LE1"), W = users.W;
  const auto edge = [&](const char* A, const char* B) { return g.path(*g.find(A), *g.find(B)).value()[0].edge; };
  CHECK(g.lookup(LE1, W, time_at(0)).status == LookupStatus::no_data);
  CHECK(g.lookup(LE1, H1, time_at(0)).status == LookupStatus::ok);
  g.push(edge("H1", "R1"), time_at(1.0), Vqs());
  g.push(edge("Hand1", "R1"), time_at(1.5), Vqs());
  // The room's place in the world is not known, and not needed.
  const Lookup hand = g.lookup(Hand1, LE1, time_at(2.0));
  CHECK(hand.status == LookupStatus::held);
  CHECK(to_seconds(hand.age) == 1.0);
  CHECK(hand.edge == edge("H1", "R1"));
  CHECK(g.lookup(Hand1, LE1, time_at(1.2)).status == LookupStatus::before_history);
  CHECK(g.lookup(Hand1, LE1, time_at(1.2)).edge == edge("Hand1", "R1"));
  CHECK(g.lookup(LE1, W, time_at(2.0)).status == LookupStatus::no_data);
  CHECK(g.lookup(LE1, W, time_at(2.0)).edge == edge("R1", "W"));
  g.push(edge("R1", "W"), time_at(0.5), Vqs());
  const Lookup eye = g.lookup(LE1, W, time_at(2.0));
  CHECK(eye.status == LookupStatus::held);
  CHECK(to_seconds(eye.age) == 1.5);
  CHECK(eye.edge == edge("R1", "W"));
}

TEST_CASE("what a lookup remembers for its time is forgotten when a sample or an edge changes") {
  FrameGraph g;
  const FrameId W = g.frame("W"), A = g.frame("A"), B = g.frame("B"), C = g.frame("C");
  const EdgeId WA = g.add_dynamic(W, A).edge, AB = g.add_dynamic(A, B).edge;
  const EdgeId BC = g.add_static(B, C, Rigid::translation(Vector3(0, 0, 1))).edge;
  g.push(WA, time_at(0), Vqs());
  g.push(AB, time_at(0), Vqs());
  const auto p_W = [&] { return g.lookup(W, C, time_at(5)).T_AB.v(); };
  CHECK(p_W() == Vector3(0, 0, 1));
  g.push(WA, time_at(4), Rigid::translation(Vector3(7, 0, 0)));
  CHECK(p_W() == Vector3(7, 0, 1));
  REQUIRE(g.set_static(BC, Rigid::translation(Vector3(0, 0, 2))));
  CHECK(p_W() == Vector3(7, 0, 2));
  REQUIRE(g.remove(BC));
  CHECK(g.lookup(W, C, time_at(5)).status == LookupStatus::no_path);
  REQUIRE(g.add_static(A, C, Rigid::translation(Vector3(0, 3, 0))));
  CHECK(p_W() == Vector3(7, 3, 0));
}

TEST_CASE("a removed edge's id never names another edge") {
  FrameGraph g;
  const FrameId A = g.frame("A"), B = g.frame("B"), C = g.frame("C");
  const EdgeId first = g.add_dynamic(A, B).edge;
  REQUIRE(g.remove(first));
  CHECK_FALSE(g.remove(first));
  const EdgeId second = g.add_dynamic(B, C).edge;
  CHECK(second.index() == first.index());
  CHECK(g.edge(first) == nullptr);
  CHECK(g.push(first, time_at(0), Vqs()) == PushStatus::not_dynamic);
  CHECK(g.push(second, time_at(0), Vqs()) == PushStatus::accepted);
}

TEST_CASE("a graph built and torn in any order answers as the product along the path") {
  std::mt19937_64 random(5);
  FrameGraph g;
  std::vector<FrameId> frames;
  for (int i = 0; i < 24; ++i) frames.push_back(g.frame("f" + std::to_string(i)));
  int refused = 0;
  for (int round = 0; round < 400; ++round) {
    const FrameId A = frames[random() % frames.size()], B = frames[random() % frames.size()];
    const bool dynamic = random() % 2 == 0;
    const bool possible = A != B && !g.connected(A, B);
    const AddedEdge added = dynamic ? g.add_dynamic(A, B) : g.add_static(A, B, random_transform(random));
    CHECK(static_cast<bool>(added) == possible);
    refused += !possible;
    if (added && dynamic) g.push(added.edge, time_at(1), random_transform(random));
    const std::vector<EdgeId> edges = g.edges();
    if (edges.size() > 20) g.remove(edges[random() % edges.size()]);
    if (edges.size() > 20) g.remove(g.edges()[random() % g.edges().size()]);

    const FrameId P = frames[random() % frames.size()], Q = frames[random() % frames.size()];
    const Lookup found = g.lookup(P, Q, time_at(1));
    const std::optional<std::vector<PathStep>> path = g.path(P, Q);
    REQUIRE(path.has_value() == found.usable());
    if (!path) continue;
    Vqs expected;
    for (const PathStep& step : *path) {
      const Vqs T = g.edge(step.edge)->at(time_at(1)).T_AB;
      expected = expected * (step.inverted ? T.inverse() : T);
    }
    // A path may have 20 transforms whose scales multiply: compare relative to the size of what moved.
    const double size = 1 + expected.v().norm() + expected.inverse().v().norm();
    CHECK(difference(found.T_AB, expected) < 1e-11 * size);
  }
  CHECK(refused > 50);  // the cycles were met
}
