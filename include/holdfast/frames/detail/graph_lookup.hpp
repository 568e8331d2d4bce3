/// The parts of FrameGraph (graph.hpp) that answer questions: lookup, path, components, and their messages.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/frames/graph.hpp>

namespace holdfast {

namespace detail {

/// Takes a sample's status and age into a lookup's: the first fault stays, else the oldest age.
inline void take_in(Lookup& lookup, const PoseHistory::Sample& sample, EdgeId edge) {
  if (sample.status == SampleStatus::interpolated || !lookup) return;
  const LookupStatus status = lookup_status(sample.status);
  const bool fault = status != LookupStatus::held;
  if (!fault && lookup.status == LookupStatus::held && sample.age <= lookup.age) return;
  lookup.status = status;
  lookup.age = sample.age;
  lookup.edge = edge;
}

}  // namespace detail

struct FrameGraph::Climb {
  std::int32_t head;
  Vqs T_head_start;
  bool is_identity;  // nothing folded in yet

  Climb(const FrameGraph& graph, FrameId start)
      : head(graph.node(start).head), T_head_start(graph.node(start).T_head_node), is_identity(head == start.index()) {}

  void left_multiply(const Vqs& T) {
    T_head_start = is_identity ? T : T * T_head_start;
    is_identity = false;
  }

  /// From this cluster's head to the head of the cluster above.
  void raise(const FrameGraph& graph, HostTime t, Lookup& result) {
    const Node& n = graph.node(head);
    const Edge& e = graph.edges_[static_cast<std::size_t>(n.parent_edge)];
    const PoseHistory::Sample sample = e.history.at(t);
    detail::take_in(result, sample, {n.parent_edge, e.generation});
    left_multiply(n.parent_is_A ? sample.T_AB : sample.T_AB.inverse());
    const Node& above = graph.node(n.parent);
    if (above.head != n.parent) left_multiply(above.T_head_node);
    head = above.head;
  }
};

inline Lookup FrameGraph::lookup(FrameId A, FrameId B, HostTime t) const {
  Lookup result;
  if (!contains(A) || !contains(B)) {
    result.status = LookupStatus::unknown_frame;
    return result;
  }
  if (node(A).root != node(B).root) {
    result.status = LookupStatus::no_path;
    return result;
  }
  if (A == B) return result;
  Climb a(*this, A), b(*this, B);
  while (a.head != b.head && result) {
    const bool raise_a = node(a.head).cluster_depth > node(b.head).cluster_depth;
    raise_a ? a.raise(*this, t, result) : b.raise(*this, t, result);
  }
  if (!result) return result;
  result.T_AB = a.is_identity   ? b.T_head_start
                : b.is_identity ? a.T_head_start.inverse()
                                : a.T_head_start.inverse() * b.T_head_start;
  return result;
}

inline std::optional<std::vector<PathStep>> FrameGraph::path(FrameId A, FrameId B) const {
  if (!connected(A, B)) return std::nullopt;
  std::vector<PathStep> from_A, from_B;
  std::int32_t a = A.index(), b = B.index();
  while (a != b) {
    const bool climb_a = node(a).depth > node(b).depth;
    std::int32_t& child = climb_a ? a : b;
    const Node& n = node(child);
    const FrameId outer(climb_a ? child : n.parent), inner(climb_a ? n.parent : child);
    (climb_a ? from_A : from_B).push_back({outer, inner, edge_id(n.parent_edge), n.parent_is_A == climb_a});
    child = n.parent;
  }
  from_A.insert(from_A.end(), from_B.rbegin(), from_B.rend());
  return from_A;
}

inline std::vector<std::vector<FrameId>> FrameGraph::components() const {
  std::vector<std::vector<FrameId>> of_root(nodes_.size());
  std::vector<std::int32_t> roots;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    std::vector<FrameId>& frames = of_root[static_cast<std::size_t>(nodes_[i].root)];
    if (frames.empty()) roots.push_back(nodes_[i].root);
    frames.emplace_back(static_cast<std::int32_t>(i));
  }
  std::vector<std::vector<FrameId>> all;
  for (const std::int32_t root : roots) all.push_back(std::move(of_root[static_cast<std::size_t>(root)]));
  return all;
}

inline std::string FrameGraph::second_way_message(FrameId A, FrameId B) const {
  std::string way = name(A);
  const std::vector<PathStep> steps = path(A, B).value();
  for (const PathStep& step : steps) way += " -> " + name(step.inner);
  return way + " already connects " + name(A) + " and " + name(B) + "; the new edge " + name(A) + " -> " + name(B) +
         " would be a second way";
}

inline std::string FrameGraph::names_of_component(FrameId f) const {
  std::string names;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].root == node(f).root) names += (names.empty() ? "" : ", ") + names_[i];
  }
  return names;
}

inline std::string FrameGraph::missing_path(FrameId A, FrameId B) const {
  if (!contains(A) || !contains(B)) return "a frame is not of this graph";
  if (connected(A, B)) return {};
  return "no path between " + name(A) + " and " + name(B) + ": " + name(A) + " is connected with {" +
         names_of_component(A) + "}, " + name(B) + " with {" + names_of_component(B) + "}";
}

}  // namespace holdfast
