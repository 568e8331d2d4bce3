#include <limits>

#include <doctest/doctest.h>

#include <holdfast/frames/display_chain.hpp>

#include "flight_helmet.hpp"

using namespace holdfast;

namespace {

struct Lab {
  FrameGraph graph;
  FrameId W = graph.frame("W"), O = graph.frame("O");
  EdgeId WO = graph.add_dynamic(W, O).edge;
  UserFrames user;

  Lab() {
    const AddedUser added = add_user(graph, W, flight_helmet_user("1"), time_at(0));
    REQUIRE(added);
    user = *added.user;
    graph.push(WO, time_at(0), Rigid::translation(Vector3(2.6, 3.0, 1.6)));
    graph.push(user.T_TB_HS, time_at(0), tracker_pose_looking_north());
  }
};

}  // namespace

TEST_CASE("table 8.1: a point before the Flight Helmet, by hand") {
  // The head is at (2.5, 1.0, 1.7) of the room, upright, looking north (+Y); world and room are the same as yet. The
  // object at (2.6, 3.0, 1.6) is 0.1 m to the right, 0.1 m down and 2 m ahead: p_H = (0.1, -0.1, -2).
  Lab lab;
  const DisplayChain left(lab.graph, lab.user, 0, lab.O), right(lab.graph, lab.user, 1, lab.O);
  const ScreenPoint l = left.trace(Vector3::Zero(), time_at(0)).value();
  const ScreenPoint r = right.trace(Vector3::Zero(), time_at(0)).value();
  // Rounding: metres of size 1.
  CHECK((l.p_E - Vector3(0.131, -0.1, -2)).norm() < 1e-14);
  CHECK((r.p_E - Vector3(0.069, -0.1, -2)).norm() < 1e-14);
  // Left: on the screen's image at 1.18 m x = 0.131 x 0.59 = 0.07729, y = -0.059. The window runs from -0.187 - 0.785 =
  // -0.972 m over 1.57 m, and from -0.595 over 1.19 m: (1.04929 / 1.57) 640 = 427.736, (0.536 / 1.19) 512 = 230.615.
  CHECK(std::abs(l.p_US.x() - 427.736) < 5e-4);  // the hand rounds at the third digit
  CHECK(std::abs(l.p_US.y() - 230.615) < 5e-4);
  // Right: x = 0.069 x 0.59 = 0.04071, window from 0.187 - 0.785 = -0.598: (0.63871 / 1.57) 640 = 260.366.
  CHECK(std::abs(r.p_US.x() - 260.366) < 5e-4);
  CHECK(std::abs(r.p_US.y() - 230.615) < 5e-4);
  // The lens must bring the drawn point to its place: r_v = r + k r^3 of p_S is p_US. 1e-9 px: the inverse's Newton
  // steps.
  CHECK((distort(left_axis, l.p_S) - l.p_US).norm() < 1e-9);
  CHECK((distort(right_axis, r.p_S) - r.p_US).norm() < 1e-9);
  // Pincushion: drawn nearer to the axis than it is seen.
  CHECK((l.p_S - left_axis).norm() < (l.p_US - left_axis).norm());
}

TEST_CASE("the folded matrix gives what the factors give") {
  Lab lab;
  const DisplayChain left(lab.graph, lab.user, 0, lab.O);
  const ScreenTransform T = left.at(time_at(0));
  REQUIRE(T);
  for (const Vector3& p_O : {Vector3(0, 0, 0), Vector3(0.3, 1, 0.2), Vector3(-0.5, 2, -0.3)}) {
    // Pixels of size 500 through one matrix or five factors: rounding, times the lens inverse's tolerance.
    CHECK((T(p_O).value() - left.trace(p_O, time_at(0)).value().p_S).norm() < 1e-9);
  }
  CHECK_FALSE(T(Vector3(0, -5, 0)).has_value());  // behind the head
  CHECK_FALSE(left.trace(Vector3(0, -5, 0), time_at(0)).has_value());
}

TEST_CASE("without a fresh pose the display transform says why") {
  Lab lab;
  const DisplayChain left(lab.graph, lab.user, 0, lab.O);
  const ScreenTransform old = left.at(time_at(0.05));
  CHECK(old.status == LookupStatus::held);
  CHECK(old.age == from_milliseconds(50));
  CHECK(left.at(time_at(-1)).status == LookupStatus::before_history);
  CHECK_FALSE(left.at(time_at(-1))(Vector3::Zero()).has_value());
  CHECK_FALSE(left.trace(Vector3::Zero(), time_at(-1)).has_value());
}

TEST_CASE("moving user and world together changes no pixel") {
  Lab lab;
  const DisplayChain left(lab.graph, lab.user, 0, lab.O);
  const Vector2 before = left.at(time_at(0))(Vector3(0.1, 0.2, 0.3)).value();
  // A similarity of the world, with scale: T_RW' = T_RW C^-1, T_WO' = C T_WO.
  const Vqs C(Vector3(3, -2, 1), so3::exp<double>(Vector3(0.4, 0.1, 2)), 7.0);
  lab.graph.push(lab.user.T_RW, time_at(1), C.inverse());
  lab.graph.push(lab.WO, time_at(1), C * Rigid::translation(Vector3(2.6, 3.0, 1.6)));
  const Vector2 after = left.at(time_at(1))(Vector3(0.1, 0.2, 0.3)).value();
  CHECK((after - before).norm() < 1e-9);  // pixels of size 500, numbers of size 10 in the chain
}

TEST_CASE("several users: each has a branch, none moves the other") {
  Lab lab;
  const AddedUser second = add_user(lab.graph, lab.W, flight_helmet_user("2"), time_at(0));
  REQUIRE(second);
  lab.graph.push(second.user->T_TB_HS, time_at(0), tracker_pose_looking_north());
  const DisplayChain eye1(lab.graph, lab.user, 0, lab.O), eye2(lab.graph, *second.user, 0, lab.O);
  const Vector2 p1 = eye1.at(time_at(0))(Vector3::Zero()).value();
  CHECK((p1 - eye2.at(time_at(0))(Vector3::Zero()).value()).norm() < 1e-12);
  lab.graph.push(second.user->T_RW, time_at(1), Rigid::translation(Vector3(0.5, 0, 0)));
  CHECK((p1 - eye1.at(time_at(1))(Vector3::Zero()).value()).norm() < 1e-12);
  CHECK(eye2.at(time_at(1))(Vector3::Zero()).value().x() > p1.x() + 50);
  // User 2 sees user 1's head where it is: the same place, moved by the 0.5 m.
  const Lookup T_H2_H1 = lab.graph.lookup(second.user->H, lab.user.H, time_at(1));
  CHECK((T_H2_H1.T_AB.v() - Vector3(0.5, 0, 0)).norm() < 1e-14);
}

TEST_CASE("a bad descriptor is refused with a message and changes nothing") {
  Lab lab;
  const std::size_t frames = lab.graph.frame_count();
  CHECK(add_user(lab.graph, lab.W, flight_helmet_user("1"), time_at(0)).message ==
        "the frame R1 is there already: give user '1' another name");
  UserDescriptor twins = flight_helmet_user("2");
  twins.eyes[1].name = "LE";
  CHECK(add_user(lab.graph, lab.W, twins, time_at(0)).message == "user '2' has two frames LE2");
  UserDescriptor broken = flight_helmet_user("2");
  broken.eyes[0].T_NE(2, 2) = std::numeric_limits<double>::infinity();
  CHECK(add_user(lab.graph, lab.W, broken, time_at(0)).message ==
        "a transform of user '2' has a number that is not finite");
  UserDescriptor nameless = flight_helmet_user("2");
  nameless.eyes[0].name.clear();
  CHECK_FALSE(add_user(lab.graph, lab.W, nameless, time_at(0)));
  CHECK_FALSE(add_user(lab.graph, FrameId(), flight_helmet_user("2"), time_at(0)));
  CHECK(lab.graph.frame_count() == frames);
}
