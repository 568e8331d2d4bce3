#include <algorithm>
#include <sstream>

#include <doctest/doctest.h>

#include <holdfast/frames/explain.hpp>

#include "flight_helmet.hpp"

using namespace holdfast;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

struct Lab {
  FrameGraph graph;
  FrameId W = graph.frame("W"), O = graph.frame("O");
  EdgeId WO = graph.add_dynamic(W, O).edge;
  UserFrames user = add_user(graph, W, flight_helmet_user("1"), time_at(0)).user.value();

  Lab() {
    graph.push(WO, time_at(0), Rigid::translation(Vector3(2.6, 3.0, 1.6)));
    graph.push(user.T_TB_HS, time_at(0), tracker_pose_looking_north());
    graph.push(user.T_TB_HS, time_at(0.01), tracker_pose_looking_north());
    graph.push(user.T_RW, time_at(0.01), Vqs());
    graph.push(WO, time_at(0.01), Rigid::translation(Vector3(2.6, 3.0, 1.6)));
  }
};

}  // namespace

TEST_CASE("an explanation has one row for each transform, in the order a point meets them, in columns") {
  Lab lab;
  const FrameId LE = *lab.graph.find("LE1");
  const std::string text = explain(lab.graph, LE, lab.O, time_at(0.005), Vector3(0, 0, 0));
  CAPTURE(text);
  const std::vector<std::string> lines = lines_of(text);
  REQUIRE(lines.size() == 12);
  CHECK(lines[0] == "T_LE1_O at t = 0.005000 s: ok");
  CHECK(lines[1] == "  T_LE1_H1 T_H1_HS1 T_HS1_TB1 T_TB1_R1 T_R1_W T_W_O");
  CHECK(lines[2].empty());
  const std::vector<std::string> order{"T_W_O", "T_R1_W", "T_TB1_R1", "T_HS1_TB1", "T_H1_HS1", "T_LE1_H1", "T_LE1_O"};
  const std::vector<std::string> kinds{"dynamic", "dynamic", "static", "dynamic", "static", "static", "whole"};
  const std::size_t kind_column = lines[3].find("kind"), v_column = lines[3].find("v ");
  for (std::size_t i = 0; i < order.size(); ++i) {
    CHECK(lines[5 + i].substr(2, order[i].size() + 1) == order[i] + " ");
    CHECK(lines[5 + i].substr(kind_column, kinds[i].size()) == kinds[i]);
    CHECK(lines[5 + i][v_column] == '(');
  }
  // The point's way, as calculated by hand in display_chain.cpp.
  CHECK(has(lines[4], "p_O ="));
  CHECK(has(lines[5], "p_W =    ( 2.6000,  3.0000,  1.6000)"));
  CHECK(has(lines[9], "p_H1 =   ( 0.1000, -0.1000, -2.0000)"));
  CHECK(has(lines[10], "p_LE1 =  ( 0.1310, -0.1000, -2.0000)"));
  CHECK(has(lines[7], "( 0.5000,  0.5000, -0.5000,  0.5000)"));  // of q and -q, the one with w >= 0
  CHECK_FALSE(has(text, "-0.0000"));
}

TEST_CASE("it tells ages, and names the edge that is oldest") {
  Lab lab;
  const std::string text = explain(lab.graph, *lab.graph.find("LE1"), lab.O, time_at(0.0135));
  CHECK(has(text, ": held, oldest age 3.5 ms (T_"));
  CHECK(has(text, "dynamic  3.5 ms  ("));
}

TEST_CASE("it explains failures: no path, no data, too old, before history") {
  Lab lab;
  FrameGraph& g = lab.graph;
  const FrameId LE = *g.find("LE1"), X = g.frame("X"), Y = g.frame("Y");
  CHECK(has(explain(g, LE, X, time_at(0)),
            "no path between LE1 and X: LE1 is connected with {W, O, R1, TB1, HS1, H1, LE1, "
            "RE1}, X with {X}"));
  CHECK(has(explain(g, LE, FrameId(), time_at(0)), "not of this graph"));
  const EdgeId XY = g.add_dynamic(X, Y, {.max_age = from_milliseconds(100)}).edge;
  CHECK(has(explain(g, X, Y, time_at(0)), "no data: T_X_Y has no sample yet"));
  g.push(XY, time_at(1), Vqs());
  const std::string old = explain(g, X, Y, time_at(1.25), Vector3::Zero());
  CHECK(has(old, "too old: the newest sample of T_X_Y is 250.0 ms old, it may be 100.0 ms"));
  CHECK(has(old, "too old (250.0 ms)"));
  CHECK(has(explain(g, X, Y, time_at(0.5)), "before history: the oldest sample of T_X_Y is of t = 1.000000 s"));
  CHECK(has(explain(g, X, X, time_at(0.5)), "identity"));
}

TEST_CASE("the display chain is explained down to the pixel") {
  Lab lab;
  const DisplayChain left(lab.graph, lab.user, 0, lab.O);
  const std::string text = explain(lab.graph, left, time_at(0.005), Vector3::Zero());
  CAPTURE(text);
  CHECK(has(text, "T_N_LE1"));
  CHECK(has(text, "p_US =  ( 427.74,  230.62) px"));
  CHECK(has(text, "T_S_US"));
  CHECK(has(explain(lab.graph, left, time_at(0.005), Vector3(0, -9, 0)), "not on the screen"));
}
