#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/frames/pose_history.hpp>

using namespace holdfast;

namespace {

Vqs turned_about_z(double angle, const Vector3& v = Vector3::Zero(), double s = 1) {
  return Vqs(v, so3::exp<double>(Vector3(0, 0, angle)), s);
}

/// Difference of two transforms: metres, radians and ratio added, for "the same within".
double difference(const Vqs& a, const Vqs& b) {
  return (a.v() - b.v()).norm() + so3::angle_between<double>(a.q(), b.q()) + std::abs(std::log(a.s() / b.s()));
}

}  // namespace

TEST_CASE("a history interpolates vector, rotation and scale") {
  PoseHistory history;
  REQUIRE(history.push(time_at(1.0), turned_about_z(0.0, Vector3(0, 0, 0), 1)) == PushStatus::accepted);
  REQUIRE(history.push(time_at(2.0), turned_about_z(0.4, Vector3(4, 0, -8), 16)) == PushStatus::accepted);
  const PoseHistory::Sample quarter = history.at(time_at(1.25));
  CHECK(quarter.status == SampleStatus::interpolated);
  CHECK(quarter.age.count() == 0);
  // Rounding of a few operations on numbers of size 1 to 8.
  CHECK(difference(quarter.T_AB, turned_about_z(0.1, Vector3(1, 0, -2), 2)) < 1e-14);
  CHECK(difference(history.at(time_at(1.0)).T_AB, turned_about_z(0)) < 1e-14);
  CHECK(difference(history.at(time_at(2.0)).T_AB, turned_about_z(0.4, Vector3(4, 0, -8), 16)) < 1e-14);
  CHECK(history.at(time_at(2.0)).status == SampleStatus::interpolated);
}

TEST_CASE("it interpolates as vqs.hpp does, for steps of any angle and either sign of the quaternion") {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  // 1e-9: a still head; 0.1 and 0.39: the series; 0.41: just beyond it; 3.1: nearly half a turn.
  for (const double angle : {0.0, 1e-9, 1e-3, 0.1, 0.39, 0.41, 1.5, 3.1}) {
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(angle);
      const Vector3 axis = Vector3(normal(random), normal(random), normal(random)).normalized();
      const Vector3 turn = angle * axis;
      const Vqs a(Vector3(1, 2, 3), so3::exp<double>(Vector3(0.3, -2.0, 1.0)), 2.0);
      Quaternion q_b = a.q() * so3::exp<double>(turn);
      q_b.coeffs() *= sign;
      const Vqs b(Vector3(-1, 0, 4), q_b, 0.5);
      PoseHistory history;
      history.push(time_at(0), a);
      history.push(time_at(1), b);
      for (const double u : {0.0, 0.1, 0.5, 0.77, 1.0}) {
        const Vqs expected = interpolate(a, b, u);
        // Two formulas for one rotation: rounding, and 3e-15 from the series' first dropped term.
        CHECK(difference(history.at(time_at(u)).T_AB, expected) < 5e-14);
      }
    }
  }
}

TEST_CASE(
    "the rotation is so3::interpolate's, for steps from nothing to half a turn and either sign of the quaternion") {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  // Up to 1e-6: a still head, where a difference of two angles keeps no digits. 0.1, 0.399: the series; 0.401: just
  // beyond it. The last: nearly half a turn, where the shorter way is least clear.
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-8, 1e-6, 1e-3, 0.1, 0.399, 0.401, 1.5, 3.1, 3.14159}) {
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(angle);
      const Vector3 axis = Vector3(normal(random), normal(random), normal(random)).normalized();
      const Vector3 turn_a(normal(random), normal(random), normal(random)), turn = angle * axis;
      const Quaternion q_a = so3::exp<double>(turn_a);
      Quaternion q_b = q_a * so3::exp<double>(turn);
      q_b.coeffs() *= sign;
      PoseHistory history;
      history.push(time_at(0), Vqs(Vector3::Zero(), q_a, 1));
      history.push(time_at(1), Vqs(Vector3::Zero(), q_b, 1));
      for (int percent = 0; percent < 100; percent += 3) {
        const Quaternion expected = so3::interpolate<double>(q_a, q_b, percent / 100.0);
        const Quaternion q = history.at(time_at(percent / 100.0)).T_AB.q();
        // Two formulas for one rotation: rounding of a few operations on unit numbers, and 3e-15 of the series.
        CHECK(so3::angle_between<double>(q, expected) < 1e-14);
      }
    }
  }
}

TEST_CASE("beyond the newest sample it holds and says how old, or refuses; it never extrapolates") {
  PoseHistory holds, refuses({.max_age = never_hold}), half({.max_age = from_milliseconds(500)});
  for (PoseHistory* h : {&holds, &refuses, &half}) {
    h->push(time_at(1), turned_about_z(0.1));
    h->push(time_at(2), turned_about_z(0.2));
  }
  const PoseHistory::Sample held = holds.at(time_at(102));
  CHECK(held.status == SampleStatus::held);
  CHECK(to_seconds(held.age) == 100.0);
  CHECK(difference(held.T_AB, turned_about_z(0.2)) < 1e-15);

  CHECK(refuses.at(time_at(2)).usable());
  CHECK(refuses.at(time_at(2) + Duration(1)).status == SampleStatus::too_old);
  CHECK(half.at(time_at(2.5)).status == SampleStatus::held);
  CHECK(half.at(time_at(2.5) + Duration(1)).status == SampleStatus::too_old);
  CHECK(half.at(time_at(3)).age == from_seconds(1));

  CHECK(holds.at(time_at(1) - Duration(1)).status == SampleStatus::before_history);
  CHECK(PoseHistory().at(time_at(0)).status == SampleStatus::empty);
}

TEST_CASE("a single sample is a history: exact at its time, held after it, unknown before") {
  PoseHistory history({.capacity = 1});
  history.push(time_at(5), turned_about_z(0.3));
  CHECK(history.at(time_at(5)).status == SampleStatus::interpolated);
  CHECK(history.at(time_at(6)).status == SampleStatus::held);
  CHECK(history.at(time_at(4)).status == SampleStatus::before_history);
}

TEST_CASE("an interval wider than max_gap is not interpolated") {
  PoseHistory history({.max_gap = from_milliseconds(100)});
  for (const double t : {0.0, 0.1, 1.0, 1.1}) history.push(time_at(t), turned_about_z(t));
  CHECK(history.at(time_at(0.05)).usable());
  CHECK(history.at(time_at(0.5)).status == SampleStatus::gap);
  CHECK(history.at(time_at(1.05)).usable());
}

TEST_CASE("bad samples are refused by name, counted, and leave the history as it was") {
  PoseHistory history;
  history.push(time_at(1), turned_about_z(0.1));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(history.push(time_at(0.9), turned_about_z(0.2)) == PushStatus::out_of_order);
  CHECK(history.push(time_at(1), turned_about_z(0.2)) == PushStatus::duplicate);
  CHECK(history.push(time_at(3), turned_about_z(0.2), time_at(2)) == PushStatus::future);
  CHECK(history.push(time_at(2), turned_about_z(0.2, Vector3(0, nan, 0))) == PushStatus::not_finite);
  CHECK(history.size() == 1);
  CHECK(difference(history.newest(), turned_about_z(0.1)) < 1e-15);
  CHECK(history.push(time_at(2), turned_about_z(0.2), time_at(2)) == PushStatus::accepted);
  CHECK(history.pushes(PushStatus::accepted) == 2);
  for (const PushStatus refused :
       {PushStatus::out_of_order, PushStatus::duplicate, PushStatus::future, PushStatus::not_finite}) {
    CHECK(history.pushes(refused) == 1);
  }
}

TEST_CASE("the ring keeps the newest samples and finds each, at even and at wild rates") {
  std::mt19937_64 random(11);
  for (const bool even : {true, false}) {
    CAPTURE(even);
    PoseHistory history({.capacity = 50});
    CHECK(history.capacity() == 64);
    std::vector<HostTime> times;
    HostTime t = time_at(10);
    for (int i = 0; i < 1000; ++i) {
      // Wild: from 1 ns to 1 s, most intervals short, as of a sensor that stalls.
      const double exponent = std::uniform_real_distribution<double>(0.0, 9.0)(random);
      t += even ? from_milliseconds(1) : Duration(1 + static_cast<std::int64_t>(std::pow(10.0, exponent)));
      times.push_back(t);
      history.push(t, turned_about_z(0, Vector3(i, 0, 0)));
    }
    CHECK(history.oldest_time() == times[1000 - 64]);
    CHECK(history.at(times[1000 - 65]).status == SampleStatus::before_history);
    for (int i = 1000 - 64; i < 1000; ++i) {
      CHECK(history.at(times[static_cast<std::size_t>(i)]).T_AB.v().x() == doctest::Approx(i).epsilon(1e-15));
    }
    for (int i = 1000 - 64; i < 999; ++i) {
      const HostTime a = times[static_cast<std::size_t>(i)], b = times[static_cast<std::size_t>(i) + 1];
      const double u = static_cast<double>(((b - a) / 3).count()) / static_cast<double>((b - a).count());
      CHECK(history.at(a + (b - a) / 3).T_AB.v().x() == doctest::Approx(i + u).epsilon(1e-14));
    }
  }
}
