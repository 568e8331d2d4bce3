// The hot path of frames allocates nothing: counted by the program's operator new and, because Eigen calls malloc
// directly, by malloc itself where the C library lets us see it.

#include <doctest/doctest.h>

#include <holdfast/frames/frames.hpp>

#include "allocation_counter.hpp"
#include "flight_helmet.hpp"

using namespace holdfast;

TEST_CASE("push, lookup, chain, display chain and steering allocate nothing") {
  FrameGraph g;
  const FrameId W = g.frame("W"), O = g.frame("O");
  const EdgeId WO = g.add_dynamic(W, O).edge;
  const UserFrames user = add_user(g, W, flight_helmet_user("1"), time_at(0)).user.value();
  g.push(WO, time_at(0), Rigid::translation(Vector3(2.6, 3.0, 1.6)));
  g.push(user.T_TB_HS, time_at(0), tracker_pose_looking_north());
  const Chain chain = g.chain(user.eyes[0].E, O);
  const DisplayChain display(g, user, 0, O);
  const FrameId LE = user.eyes[0].E, RE = user.eyes[1].E, elsewhere = g.frame("elsewhere");

  double sum = 0;
  const std::size_t before = test::allocations();
  Eigen::internal::set_is_malloc_allowed(false);
  for (int i = 1; i <= 1000; ++i) {
    const HostTime t = time_at(0.001 * i);
    g.push(user.T_TB_HS, t, tracker_pose_looking_north());
    g.push(user.T_TB_HS, t, tracker_pose_looking_north());  // refused
    steer(g, user.T_RW, t, [](const Vqs& T_RW) { return fly(T_RW, Vector3(0, 0.1, 0), from_milliseconds(1)); });
    const HostTime ask = t - Duration(300'000);
    sum += g.lookup(LE, O, ask).T_AB.v().x() + g.lookup(LE, RE, ask).T_AB.v().x();
    sum += g.lookup(user.HS, user.H, ask).T_AB.s() + g.lookup(user.HS, user.R, ask).T_AB.s();
    sum += g.lookup(LE, elsewhere, ask).T_AB.s() + g.lookup(LE, O, time_at(-1)).T_AB.s();
    sum += chain.at(ask).T_AB.v().x();
    const std::optional<Vector2> pixel = display.at(ask)(Vector3::Zero());
    if (pixel) sum += pixel->x();
  }
  Eigen::internal::set_is_malloc_allowed(true);
  const std::size_t after = test::allocations();
  CHECK(after == before);
  CHECK(std::isfinite(sum));
  CHECK(test::counts_allocations());
}
