#include <doctest/doctest.h>

#include <holdfast/frames/navigation.hpp>

using namespace holdfast;

namespace {

const Vqs T_RW0(Vector3(0.4, -1.0, 2.0), so3::exp<double>(Vector3(0.2, 0.7, -0.3)), 0.5);
// Numbers of size 1 through a few products: rounding.
constexpr double rounding = 1e-14;

double difference(const Vqs& a, const Vqs& b) {
  return (a.v() - b.v()).norm() + so3::angle_between<double>(a.q(), b.q()) + std::abs(a.s() - b.s());
}

}  // namespace

TEST_CASE("flying moves the room through the world where the hand points, at speed x dt") {
  const Quaternion q_R_Hand = so3::exp<double>(Vector3(0.1, -0.8, 0.0));
  const Vector3 pointing_R = q_R_Hand * Vector3(0, 0, -1);
  const Vqs T_RW = fly(T_RW0, 2.0 * pointing_R, from_milliseconds(250));
  // A point of the world comes nearer by 0.5 m, felt in the room.
  const Vector3 p_W(3, 1, -2);
  CHECK((T_RW * p_W - (T_RW0 * p_W - 0.5 * pointing_R)).norm() < rounding);
  // The room's origin moved through the world the same way: 0.5 m of the room are 1 unit of a world drawn at half size.
  const Vector3 moved_W = T_RW.inverse().v() - T_RW0.inverse().v();
  const Vector3 pointing_W = T_RW0.q().conjugate() * pointing_R;
  CHECK((moved_W - 1.0 * pointing_W).norm() < rounding);
  CHECK(T_RW.s() == T_RW0.s());
  CHECK(so3::angle_between<double>(T_RW.q(), T_RW0.q()) < rounding);
}

TEST_CASE("flying in many small steps is flying in one") {
  const Vector3 v_R(0.3, -1.2, 0.5);
  Vqs T_RW = T_RW0;
  for (int i = 0; i < 90; ++i) T_RW = fly(T_RW, v_R, from_milliseconds(11));
  // 90 additions.
  CHECK(difference(T_RW, fly(T_RW0, v_R, from_milliseconds(990))) < 1e-13);
}

TEST_CASE("tilting turns the world about a point that stays, by the angle asked for") {
  const Vector3 head_R(1.0, 0.5, 1.7);
  const Quaternion q = so3::exp<double>(Vector3(0.3, 0, 0));
  const Vqs T_RW = tilt(T_RW0, q, head_R);
  const Vector3 under_head_W = T_RW0.inverse() * head_R;
  CHECK((T_RW * under_head_W - head_R).norm() < rounding);
  CHECK(so3::angle_between<double>(T_RW0.q(), T_RW.q()) == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(T_RW.s() == doctest::Approx(T_RW0.s()).epsilon(1e-15));
  // Any other point goes round the head: same distance, room axes.
  const Vector3 p_W(3, 1, -2);
  const Vector3 before = T_RW0 * p_W - head_R, after = T_RW * p_W - head_R;
  CHECK((after - q * before).norm() < rounding);
}

TEST_CASE("scaling about a point leaves that point where it is and moves others away by the factor") {
  const Vector3 hand_R(0.2, 1.1, 1.3);
  const Vqs T_RW = scale_world(T_RW0, 1.25, hand_R);
  const Vector3 in_hand_W = T_RW0.inverse() * hand_R;
  CHECK((T_RW * in_hand_W - hand_R).norm() < rounding);
  CHECK(T_RW.s() == doctest::Approx(0.625).epsilon(1e-15));
  const Vector3 p_W(3, 1, -2);
  CHECK((T_RW * p_W - hand_R - 1.25 * (T_RW0 * p_W - hand_R)).norm() < rounding);
  CHECK(difference(scale_world(T_RW, 1 / 1.25, hand_R), T_RW0) < rounding);
}

TEST_CASE("shrinking a little each frame for a long time stays a similarity about its point") {
  const Vector3 hand_R(0.2, 1.1, 1.3);
  const Vector3 in_hand_W = T_RW0.inverse() * hand_R;
  Vqs T_RW = T_RW0;
  for (int i = 0; i < 900; ++i) T_RW = scale_world(T_RW, 0.99, hand_R);
  CHECK(T_RW.s() == doctest::Approx(0.5 * std::pow(0.99, 900)).epsilon(1e-12));
  // 900 products, each with an error of some 1e-16 of a metre.
  CHECK((T_RW * in_hand_W - hand_R).norm() < 1e-12);
  CHECK(T_RW.q().norm() == doctest::Approx(1).epsilon(1e-14));
}

TEST_CASE("while grabbed, the object's pose in the hand is constant; at release it stays in the world") {
  const Vqs T_WO0(Vector3(1, 0.2, -1), so3::exp<double>(Vector3(0, 0.4, 0.1)), 3.0);
  const Vqs T_W_Hand0(Vector3(0.9, 0.1, -0.8), so3::exp<double>(Vector3(0.5, 0, 0)), 2.0);
  const Grab grab(T_W_Hand0, T_WO0);
  CHECK(difference(grab.T_WO(T_W_Hand0), T_WO0) < rounding);  // closing the hand moves nothing
  Vqs T_WO = T_WO0;
  for (int i = 1; i <= 50; ++i) {
    const double a = 0.1 * i;
    // The user may even be scaled meanwhile: the hand's scale in the world changes and the object's with it.
    const Vqs T_W_Hand(Vector3(std::cos(a), std::sin(a), -1), so3::exp<double>(Vector3(a, 0.3, -a)), 2.0 + 0.1 * a);
    T_WO = grab.T_WO(T_W_Hand);
    CHECK(difference(T_W_Hand.inverse() * T_WO, grab.T_Hand_O()) < 10 * rounding);
  }
}

TEST_CASE("a grabbed world follows the hand") {
  const Vqs T_R_Hand0(Rigid(so3::exp<double>(Vector3(0, 0.3, 0)), Vector3(0.3, 1, -0.2)));
  const Vqs T_R_Hand1(Rigid(so3::exp<double>(Vector3(0.2, 0.9, 0)), Vector3(0.1, 1.2, 0.2)));
  const WorldGrab grab(T_R_Hand0, T_RW0);
  CHECK(difference(grab.T_RW(T_R_Hand0), T_RW0) < rounding);
  const Vqs T_RW = grab.T_RW(T_R_Hand1);
  const Vector3 p_W(3, 1, -2);
  CHECK((T_R_Hand1.inverse() * (T_RW * p_W) - T_R_Hand0.inverse() * (T_RW0 * p_W)).norm() < rounding);
}

TEST_CASE("steering pushes the operation's result as a new sample of the edge") {
  FrameGraph graph;
  const FrameId R = graph.frame("R"), W = graph.frame("W");
  const EdgeId edge = graph.add_dynamic(R, W).edge;
  const auto ahead = [](const Vqs& T_RW) { return fly(T_RW, Vector3(0, 0, -1), from_seconds(1)); };
  CHECK(steer(graph, edge, time_at(1), ahead) == PushStatus::not_dynamic);  // nothing to start from
  graph.push(edge, time_at(0), T_RW0);
  CHECK(steer(graph, edge, time_at(1), ahead) == PushStatus::accepted);
  CHECK(difference(graph.lookup(R, W, time_at(1)).T_AB, ahead(T_RW0)) < rounding);
  CHECK(difference(graph.lookup(R, W, time_at(0)).T_AB, T_RW0) < rounding);
  CHECK(steer(graph, edge, time_at(1), ahead) == PushStatus::duplicate);
}

TEST_CASE("grabbing in the graph: the object keeps its place in the hand while the user flies and turns") {
  FrameGraph graph;
  const FrameId W = graph.frame("W"), R = graph.frame("R"), Hand = graph.frame("Hand"), O = graph.frame("O");
  const EdgeId RW = graph.add_dynamic(R, W).edge, R_Hand = graph.add_dynamic(R, Hand).edge;
  const EdgeId WO = graph.add_dynamic(W, O).edge;
  graph.push(RW, time_at(0), T_RW0);
  graph.push(R_Hand, time_at(0), Rigid::translation(Vector3(0.3, 0.2, 1.1)));
  graph.push(WO, time_at(0), Rigid::translation(Vector3(1, 2, 3)));
  const Grab grab(graph.lookup(W, Hand, time_at(0)).T_AB, graph.lookup(W, O, time_at(0)).T_AB);
  for (int i = 1; i < 20; ++i) {
    const HostTime t = time_at(0.01 * i);
    steer(graph, RW, t, [&](const Vqs& T) { return fly(T, Vector3(1, 0, 0), from_milliseconds(10)); });
    graph.push(R_Hand, t, Rigid(so3::exp<double>(Vector3(0, 0.1 * i, 0)), Vector3(0.3, 0.2 + 0.01 * i, 1.1)));
    graph.push(WO, t, grab.T_WO(graph.lookup(W, Hand, t).T_AB));
    CHECK(difference(graph.lookup(Hand, O, t).T_AB, grab.T_Hand_O()) < 10 * rounding);
  }
}
