/// The coordinate-system graph as a Graphviz drawing, in the manner of figure 5.1 of Robinett & Holloway 1994 (course
/// 11).
///
/// `dot -Tsvg` of the text draws frames as boxes, hung from the first frame of each component (register the world
/// first), static transforms as thin grey lines, dynamic ones as thick coloured lines with their age at time t; a
/// dynamic transform that cannot be used at t is dashed and says why. Each line carries the name T_A_B under which its
/// edge was added.
#pragma once

#include <string>
#include <vector>

#include <holdfast/frames/explain.hpp>
#include <holdfast/frames/graph.hpp>

namespace holdfast {

namespace detail {

/// A double-quoted DOT string.
inline std::string dot_quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

inline std::string dot_edge_style(const FrameGraph& graph, const FrameGraph::Edge& e, HostTime t) {
  const std::string name = "T_" + graph.name(e.A) + "_" + graph.name(e.B);
  if (e.kind == EdgeKind::fixed)
    return "color=\"#8a94a6\", fontcolor=\"#5b6472\", label=" + dot_quoted(" " + name + " ");
  const PoseHistory::Sample sample = e.at(t);
  std::string style = "color=\"#c2410c\", fontcolor=\"#9a3412\", penwidth=2.2, ";
  if (!sample.usable()) style += "style=dashed, ";
  // The label's line break is DOT's own escape, hence added after quoting.
  std::string label = dot_quoted(" " + name + " ");
  label.insert(label.size() - 1, "\\n " + age_text(e, sample) + " ");
  return style + "label=" + label;
}

}  // namespace detail

[[nodiscard]] inline std::string to_dot(const FrameGraph& graph, HostTime t) {
  std::string text =
      "digraph frames {\n"
      "  graph [bgcolor=white, nodesep=0.5, ranksep=0.45, pad=0.2];\n"
      "  node [shape=box, style=\"rounded,filled\", fillcolor=\"#eef2f8\", color=\"#4a5a75\", fontname=\"Helvetica\", "
      "fontsize=13, "
      "height=0.36, margin=\"0.16,0.06\"];\n"
      "  edge [dir=none, fontname=\"Helvetica\", fontsize=10, penwidth=1.2];\n";
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(graph.frame_count()); ++i) {
    text += "  f" + std::to_string(i) + " [label=" + detail::dot_quoted(graph.name(FrameId(i))) + "];\n";
  }
  for (const std::vector<FrameId>& component : graph.components()) {
    const FrameId top = component.front();
    for (const FrameId f : component) {
      if (f == top) continue;
      const PathStep last = graph.path(top, f)->back();  // the edge above f
      text += "  f" + std::to_string(last.outer.index()) + " -> f" + std::to_string(f.index()) + " [" +
              detail::dot_edge_style(graph, *graph.edge(last.edge), t) + "];\n";
    }
  }
  return text + "}\n";
}

}  // namespace holdfast
