/// T_AB in words: every transform of its chain with kind, age, v, q and s, and what each does to a point.
///
/// For people who look for the wrong sign, the stale tracker or the millimetres taken for metres. Steps come in the
/// order in which a point meets them, rightmost factor first. Text in aligned columns, for a fixed-width font;
/// allocates freely. A failed lookup is explained too: which frames are not connected, which edge has no sample, is too
/// old, and by how much.
#pragma once

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/frames/display_chain.hpp>
#include <holdfast/frames/graph.hpp>

namespace holdfast {

namespace detail {

/// `digits` after the point, room for a sign, and no "-0.000".
inline std::string fixed_text(double x, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "% .*f", digits, x);
  if (text[0] == '-' && std::string(text).find_first_of("123456789ni") == std::string::npos) text[0] = ' ';
  return text;
}

template <typename Vector>
std::string vector_text(const Vector& v, int digits) {
  std::string text = "(";
  for (int i = 0; i < v.size(); ++i) text += (i ? ", " : "") + fixed_text(v[i], digits);
  return text + ")";
}

/// (x, y, z, w), of the two signs the one with w >= 0, so that equal rotations read alike.
inline std::string quaternion_text(const Quaternion& q) {
  const Vector4 xyzw(q.x(), q.y(), q.z(), q.w());
  const Vector4 shown = q.w() < 0 ? Vector4(-xyzw) : xyzw;
  return vector_text(shown, 4);
}

inline std::string milliseconds_text(Duration d) {
  return fixed_text(to_milliseconds(d), 1).substr(1) + " ms";
}

inline std::string transform_name(const FrameGraph& graph, FrameId A, FrameId B) {
  return "T_" + graph.name(A) + "_" + graph.name(B);
}

/// Pads every column to its widest cell; two blanks between columns, none at a line's end.
inline std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const std::vector<std::string>& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    std::string line = "  ";
    for (std::size_t i = 0; i < row.size(); ++i) line += row[i] + std::string(widths[i] - row[i].size() + 2, ' ');
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

inline std::string age_text(const FrameGraph::Edge& e, const PoseHistory::Sample& sample) {
  if (e.kind == EdgeKind::fixed) return "-";
  switch (sample.status) {
    case SampleStatus::interpolated:
      return "0.0 ms";
    case SampleStatus::held:
      return milliseconds_text(sample.age);
    case SampleStatus::too_old:
      return "too old (" + milliseconds_text(sample.age) + ")";
    default:
      return to_string(lookup_status(sample.status));
  }
}

}  // namespace detail

/// One line on a lookup's outcome: "held, oldest age 3.5 ms (T_TB_HS)", "no path between A and B: ...".
[[nodiscard]] inline std::string describe(const FrameGraph& graph, FrameId A, FrameId B, const Lookup& lookup) {
  if (lookup.status == LookupStatus::no_path) return graph.missing_path(A, B);
  if (lookup.status == LookupStatus::unknown_frame) return "a frame is not of this graph";
  const FrameGraph::Edge* e = graph.edge(lookup.edge);
  if (!e) return to_string(lookup.status);
  const std::string name = detail::transform_name(graph, e->A, e->B);
  switch (lookup.status) {
    case LookupStatus::held:
      return "held, oldest age " + detail::milliseconds_text(lookup.age) + " (" + name + ")";
    case LookupStatus::too_old:
      return "too old: the newest sample of " + name + " is " + detail::milliseconds_text(lookup.age) +
             " old, it may be " + detail::milliseconds_text(e->history.options().max_age);
    case LookupStatus::before_history:
      return "before history: the oldest sample of " + name +
             " is of t =" + detail::fixed_text(to_seconds(e->history.oldest_time().time_since_epoch()), 6) + " s";
    case LookupStatus::no_data:
      return "no data: " + name + " has no sample yet";
    default:
      return std::string(to_string(lookup.status)) + ": " + name;
  }
}

/// T_AB at time t, and p_B on its way through the chain when it is given.
[[nodiscard]] inline std::string explain(const FrameGraph& graph, FrameId A, FrameId B, HostTime t,
                                         const std::optional<Vector3>& p_B = std::nullopt) {
  const Lookup whole = graph.lookup(A, B, t);
  const std::string when = " at t =" + detail::fixed_text(to_seconds(t.time_since_epoch()), 6) + " s: ";
  const std::optional<std::vector<PathStep>> path = graph.path(A, B);
  if (!path) {
    const bool known = graph.contains(A) && graph.contains(B);
    return (known ? detail::transform_name(graph, A, B) : std::string("T_?_?")) + when + describe(graph, A, B, whole) +
           "\n";
  }
  std::string text = detail::transform_name(graph, A, B) + when + describe(graph, A, B, whole) + "\n ";
  for (const PathStep& step : *path) text += " " + detail::transform_name(graph, step.outer, step.inner);
  text += path->empty() ? " identity\n\n" : "\n\n";

  std::vector<std::vector<std::string>> rows{{"transform", "kind", "age", "v", "q (x, y, z, w)", "s"}};
  if (p_B) rows[0].push_back("point");
  if (p_B) rows.push_back({"", "", "", "", "", "", "p_" + graph.name(B) + " =", detail::vector_text(*p_B, 4)});
  std::optional<Vector3> p = p_B;
  for (auto step = path->rbegin(); step != path->rend(); ++step) {
    const FrameGraph::Edge& e = *graph.edge(step->edge);
    const PoseHistory::Sample sample = e.at(t);
    const std::string name = detail::transform_name(graph, step->outer, step->inner);
    const std::string kind = e.kind == EdgeKind::fixed ? "static" : "dynamic";
    if (!sample.usable()) {
      rows.push_back({name, kind, detail::age_text(e, sample)});
      p.reset();
      continue;
    }
    const Vqs T = step->inverted ? sample.T_AB.inverse() : sample.T_AB;
    rows.push_back({name, kind, detail::age_text(e, sample), detail::vector_text(T.v(), 4),
                    detail::quaternion_text(T.q()), detail::fixed_text(T.s(), 4)});
    if (p) {
      p = T * *p;
      rows.back().push_back("p_" + graph.name(step->outer) + " =");
      rows.back().push_back(detail::vector_text(*p, 4));
    }
  }
  if (whole && path->size() > 1) {
    rows.push_back({detail::transform_name(graph, A, B), "whole", detail::milliseconds_text(whole.age),
                    detail::vector_text(whole.T_AB.v(), 4), detail::quaternion_text(whole.T_AB.q()),
                    detail::fixed_text(whole.T_AB.s(), 4)});
  }
  return text + detail::aligned(rows);
}

/// The complete display chain of a point: the graph's part as above, then normalized, undistorted screen, screen.
[[nodiscard]] inline std::string explain(const FrameGraph& graph, const DisplayChain& display, HostTime t,
                                         const Vector3& p_O) {
  std::string text = explain(graph, display.E(), display.O(), t, p_O);
  const std::optional<ScreenPoint> p = display.trace(p_O, t);
  if (!p) return text + "\n  not on the screen: no transform, not in front of the eye, or outside the lens\n";
  return text + "\n" +
         detail::aligned({{"T_N_" + graph.name(display.E()), "perspective", "p_N =", detail::vector_text(p->p_N, 4)},
                          {"T_US_N", "viewport", "p_US =", detail::vector_text(p->p_US, 2) + " px"},
                          {"T_S_US", "lens", "p_S =", detail::vector_text(p->p_S, 2) + " px"}});
}

}  // namespace holdfast
