#include <random>

#include <doctest/doctest.h>

#include <holdfast/frames/chain.hpp>

using namespace holdfast;

namespace {

Vqs random_transform(std::mt19937_64& random) {
  std::normal_distribution<double> n;
  const Vector3 turn(n(random), n(random), n(random));
  return Vqs(Vector3(n(random), n(random), n(random)), so3::exp<double>(turn), std::exp(0.1 * n(random)));
}

}  // namespace

TEST_CASE("a chain gives what the graph's lookup gives, for every mix and direction of edges") {
  std::mt19937_64 random(21);
  for (unsigned mix = 0; mix < 64; ++mix) {  // which of six edges are dynamic
    CAPTURE(mix);
    FrameGraph g;
    std::vector<FrameId> f;
    for (int i = 0; i < 7; ++i) f.push_back(g.frame("f" + std::to_string(i)));
    std::size_t dynamic = 0;
    for (unsigned i = 0; i < 6; ++i) {
      const bool upside_down = random() % 2 == 0;
      const FrameId A = f[upside_down ? i + 1 : i], B = f[upside_down ? i : i + 1];
      if (!(mix >> i & 1)) {
        REQUIRE(g.add_static(A, B, random_transform(random)));
        continue;
      }
      const EdgeId e = g.add_dynamic(A, B).edge;
      for (const double t : {0.0, 1.0, 2.0}) g.push(e, time_at(t), random_transform(random));
      ++dynamic;
    }
    const Chain chain = g.chain(f.front(), f.back()), back = g.chain(f.back(), f.front());
    CHECK(chain.transforms() == 6);
    CHECK(chain.dynamic_transforms() == dynamic);
    for (const double t : {-1.0, 0.25, 1.5, 3.0}) {
      // Asked first at a time, a chain evaluates its edges itself; asked again it uses what the graph remembers.
      const Lookup first = chain.at(time_at(t)), again = chain.at(time_at(t));
      const Lookup a = g.lookup(f.front(), f.back(), time_at(t));
      const Vector3 p(0.3, -0.2, 0.9);
      for (const Lookup& b : {first, again}) {
        CHECK(a.status == b.status);
        CHECK(a.age == b.age);
        CHECK(a.edge == b.edge);
        // Six transforms of numbers of size 1: rounding.
        if (b) CHECK((a.T_AB * p - b.T_AB * p).norm() < 1e-13);
      }
      static_cast<void>(chain.at(time_at(-9)));  // another time, so that the way back is evaluated too
      const Lookup returned = back.at(time_at(t));
      CHECK(returned.status == a.status);
      if (a) CHECK((returned.T_AB * (a.T_AB * p) - p).norm() < 1e-12);
    }
  }
}

TEST_CASE("a chain of more dynamic edges than it evaluates in one go is the product of them all") {
  FrameGraph g;
  std::mt19937_64 random(22);
  FrameId outer = g.frame("f0");
  Vqs expected;
  for (int i = 1; i <= 20; ++i) {
    const FrameId inner = g.frame("f" + std::to_string(i));
    const Vqs T = random_transform(random);
    const EdgeId e = g.add_dynamic(outer, inner).edge;
    g.push(e, time_at(0), T);
    g.push(e, time_at(1), T);
    expected = expected * T;
    outer = inner;
  }
  const Lookup whole = g.chain(*g.find("f0"), outer).at(time_at(0.5));
  REQUIRE(whole.status == LookupStatus::ok);
  // Twenty products of numbers of size 1, their sum below 100: rounding.
  CHECK((whole.T_AB.v() - expected.v()).norm() < 1e-12);
  CHECK(so3::angle_between<double>(whole.T_AB.q(), expected.q()) < 1e-13);
  CHECK(whole.T_AB.s() == doctest::Approx(expected.s()).epsilon(1e-13));
}

TEST_CASE("new samples do not make a chain stale; a changed graph does, and it says so") {
  FrameGraph g;
  const FrameId A = g.frame("A"), B = g.frame("B"), C = g.frame("C");
  const EdgeId AB = g.add_static(A, B, Vqs()).edge, BC = g.add_dynamic(B, C).edge;
  g.push(BC, time_at(0), Vqs());
  const Chain chain = g.chain(A, C);
  CHECK(chain.at(time_at(0)).status == LookupStatus::ok);
  g.push(BC, time_at(1), Rigid::translation(Vector3(1, 0, 0)));
  CHECK(chain.valid());
  CHECK(chain.at(time_at(1)).T_AB.v().x() == 1.0);
  REQUIRE(g.set_static(AB, Rigid::translation(Vector3(0, 5, 0))));
  CHECK_FALSE(chain.valid());
  CHECK(chain.at(time_at(1)).status == LookupStatus::stale_chain);
  CHECK(g.chain(A, C).at(time_at(1)).T_AB.v() == Vector3(1, 5, 0));
}

TEST_CASE("a chain with no path answers as the lookup does") {
  FrameGraph g;
  const FrameId A = g.frame("A"), B = g.frame("B");
  CHECK(g.chain(A, B).at(time_at(0)).status == LookupStatus::no_path);
  CHECK(g.chain(A, FrameId()).at(time_at(0)).status == LookupStatus::unknown_frame);
  CHECK(Chain().at(time_at(0)).status == LookupStatus::no_path);
}
