// The coordinate systems of one user and one object as a graph: where everything is at a time, why, and how to move in
// it. Prints an explanation of the left eye's view of a cup; with --dot, the graph for Graphviz:  sample_frame_graph
// --dot | dot -Tsvg
#include <cstdio>
#include <cstring>

#include <holdfast/frames/frames.hpp>

using namespace holdfast;

int main(int argc, char** argv) {
  FrameGraph graph;

  // Frames: world, the user's room, tracker base, head sensor, head, eyes, hand, and a cup.
  const FrameId W = graph.frame("W"), R = graph.frame("R"), TB = graph.frame("TB"), HS = graph.frame("HS");
  const FrameId H = graph.frame("H"), LE = graph.frame("LE"), RE = graph.frame("RE");
  const FrameId Hand = graph.frame("Hand"), Cup = graph.frame("Cup");

  // Independent transforms. Static ones were measured once; dynamic ones get samples while the program runs.
  const Quaternion base_hangs_upside_down = so3::exp<double>(Vector3(0, 0, 3.14159265358979));
  const Quaternion sensor_is_pitched = so3::exp<double>(Vector3(0.35, 0, 0));
  graph.add_static(R, TB, Rigid(base_hangs_upside_down, Vector3(0, 2.4, -1.0)));
  graph.add_static(H, HS, Rigid(sensor_is_pitched, Vector3(0, 0.12, -0.04)));
  graph.add_static(H, LE, Rigid::translation(Vector3(-0.031, 0, 0)));
  graph.add_static(H, RE, Rigid::translation(Vector3(+0.031, 0, 0)));
  const EdgeId RW = graph.add_dynamic(R, W).edge;
  const EdgeId WCup = graph.add_dynamic(W, Cup).edge;
  const EdgeId TB_HS = graph.add_dynamic(TB, HS, {.max_age = from_milliseconds(100)}).edge;
  const EdgeId TB_Hand = graph.add_dynamic(TB, Hand, {.max_age = from_milliseconds(100)}).edge;

  // There is one way between any two frames; a second is refused, and the answer says which one there is.
  const AddedEdge second = graph.add_dynamic(W, H);
  if (argc == 1) std::printf("%s\n\n", second.message.c_str());

  // The world fills the room at half size, with a cup in it; tracker samples come at 100 Hz.
  graph.push(RW, time_at(0), Vqs(Vector3(0, 0, 0), Quaternion::Identity(), 0.5));
  graph.push(WCup, time_at(0), Rigid::translation(Vector3(0.2, 2.8, -3.0)));
  for (int i = 0; i <= 10; ++i) {
    const double t = 0.01 * i;
    const Quaternion q_R_HS = so3::exp<double>(Vector3(0, 1.0 * t, 0)) * sensor_is_pitched;
    const Rigid X_R_HS(q_R_HS, Vector3(0.3 * t, 1.8, 0.2));
    const Vqs T_TB_R = graph.lookup(TB, R, time_at(t)).T_AB;
    graph.push(TB_HS, time_at(t), T_TB_R * X_R_HS);
    graph.push(TB_Hand, time_at(t), T_TB_R * Rigid::translation(Vector3(0.2, 1.2 + t, -0.4)));
  }

  // Between samples the tracker's pose is interpolated; beyond the newest it is held, and its age told.
  const HostTime display_time = time_at(0.1035);
  if (argc == 2 && std::strcmp(argv[1], "--dot") == 0) {
    std::fputs(to_dot(graph, display_time).c_str(), stdout);
    return 0;
  }
  std::printf("%s\n", explain(graph, LE, Cup, display_time, Vector3(0, 0, 0)).c_str());

  // A renderer resolves its chains once and asks them every frame.
  const Chain T_LE_Cup = graph.chain(LE, Cup);
  const Vector3 seen_LE = T_LE_Cup.at(display_time).T_AB * Vector3(0, 0, 0);

  // The hand closes on the cup; the user flies ahead at 2 m/s for half a second; the cup comes along.
  const HostTime later = time_at(0.6);
  const Grab grab(graph.lookup(W, Hand, time_at(0.1)).T_AB, graph.lookup(W, Cup, time_at(0.1)).T_AB);
  steer(graph, RW, later, [](const Vqs& T_RW) { return fly(T_RW, Vector3(0, 0, -2.0), from_milliseconds(500)); });
  graph.push(TB_HS, later, graph.edge(TB_HS)->history.newest());
  graph.push(TB_Hand, later, graph.edge(TB_Hand)->history.newest());
  graph.push(WCup, later, grab.T_WO(graph.lookup(W, Hand, later).T_AB));
  const Vector3 flown_LE = T_LE_Cup.at(later).T_AB * Vector3(0, 0, 0);
  std::printf(
      "the cup before the left eye: (%.3f, %.3f, %.3f) m, after flying with it in the hand: (%.3f, %.3f, %.3f) m\n",
      seen_LE.x(), seen_LE.y(), seen_LE.z(), flown_LE.x(), flown_LE.y(), flown_LE.z());

  // What cannot be known is not made up.
  std::printf("%s\n", describe(graph, LE, Cup, graph.lookup(LE, Cup, time_at(0.75))).c_str());
  return 0;
}
