/// The parts of FrameGraph (graph.hpp) that answer questions: lookup, path, components, and their messages.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/frames/graph.hpp>

namespace holdfast {

namespace detail {

/// Takes a status and age on the way into a result's: the first fault stays, else the oldest age, of equals the edge
/// that was added first.
template <typename Result>
void take_in(Result& result, Duration age, LookupStatus status, EdgeId edge) {
  if (status == LookupStatus::ok || !result) return;
  if (status == LookupStatus::held && result.status == LookupStatus::held) {
    if (age < result.age || (age == result.age && edge.index() > result.edge.index())) return;
  }
  result.status = status;
  result.age = age;
  result.edge = edge;
}

}  // namespace detail

/// A frame on its way to the root, from cluster head to cluster head.
struct FrameGraph::Climb {
  std::int32_t head;
  detail::RawVqs T_head_start;

  Climb(const FrameGraph& graph, FrameId start)
      : head(graph.node(start).head), T_head_start(graph.node(start).T_head_node) {}

  /// From this cluster's head to the head of the cluster above.
  void raise(const FrameGraph& graph, HostTime t, Lookup& result) {
    const Node& n = graph.node(head);
    const Edge& e = graph.edges_[static_cast<std::size_t>(n.parent_edge)];
    detail::RawVqs T_AB = Vqs();
    const PoseHistory::RawSample sample = e.history.at(t, T_AB);
    detail::take_in(result, sample.age, lookup_status(sample.status), {n.parent_edge, e.generation});
    n.parent_is_A ? multiply(T_AB, T_head_start, T_head_start) : divide(T_AB, T_head_start, T_head_start);
    const Node& above = graph.node(n.parent);
    if (above.head != n.parent) multiply(above.T_head_node, T_head_start, T_head_start);
    head = above.head;
  }
};

/// T_root_frame at time t, remembered until the time or the graph changes.
inline const FrameGraph::Seen& FrameGraph::from_root(std::int32_t frame, HostTime t) const {
  const Seen& seen = seen_[static_cast<std::size_t>(frame)];
  return seen.t == t && seen.changes == changes_ ? seen : see(frame, t);
}

inline const FrameGraph::Seen& FrameGraph::see(std::int32_t frame, HostTime t) const {
  Seen& seen = seen_[static_cast<std::size_t>(frame)];
  const Node& n = node(frame);
  const bool is_head = n.head == frame;
  seen.t = t;
  seen.changes = changes_;
  seen.status = LookupStatus::ok;
  seen.age = Duration(0);
  seen.T_root_frame = n.T_head_node;
  if (n.parent < 0) return seen;
  const std::int32_t above = is_head ? n.parent : n.head;
  const Seen& up = from_root(above, t);
  detail::take_in(seen, up.age, up.status, up.edge);
  if (is_head) {
    const Edge& e = edges_[static_cast<std::size_t>(n.parent_edge)];
    const PoseHistory::RawSample sample = e.history.at(t, seen.T_root_frame);
    detail::take_in(seen, sample.age, lookup_status(sample.status), {n.parent_edge, e.generation});
    if (!n.parent_is_A) divide(seen.T_root_frame, Vqs(), seen.T_root_frame);
  }
  if (above != n.root) multiply(up.T_root_frame, seen.T_root_frame, seen.T_root_frame);
  return seen;
}

/// The way leads through the root's cluster, and the two are not both in it.
inline bool FrameGraph::by_root(const Node& a, const Node& b) {
  return a.branch != b.branch;
}

inline Lookup FrameGraph::lookup(FrameId A, FrameId B, HostTime t) const {
  asked_t_ = t;
  Lookup result;
  if (!contains(A) || !contains(B)) {
    result.status = LookupStatus::unknown_frame;
    return result;
  }
  const Node &nA = node(A), &nB = node(B);
  if (nA.root != nB.root) {
    result.status = LookupStatus::no_path;
    return result;
  }
  if (by_root(nA, nB)) return lookup_by_root(A, B, t);
  if (A == B) return result;
  return lookup_below_root(A, B, t);
}

/// T_AB = T_root_A^-1 T_root_B.
inline Lookup FrameGraph::lookup_by_root(FrameId A, FrameId B, HostTime t) const {
  Lookup result;
  const Seen &a = from_root(A.index(), t), &b = from_root(B.index(), t);
  detail::take_in(result, a.age, a.status, a.edge);
  detail::take_in(result, b.age, b.status, b.edge);
  detail::RawVqs T_AB;
  divide(a.T_root_frame, b.T_root_frame, T_AB);
  if (result) result.T_AB = to_vqs(T_AB);
  return result;
}

/// Frames of one branch, or of the root's cluster: what is above their meeting must not be asked.
inline Lookup FrameGraph::lookup_below_root(FrameId A, FrameId B, HostTime t) const {
  Lookup result;
  Climb a(*this, A), b(*this, B);
  while (a.head != b.head && result) {
    const bool raise_a = node(a.head).cluster_depth > node(b.head).cluster_depth;
    raise_a ? a.raise(*this, t, result) : b.raise(*this, t, result);
  }
  divide(a.T_head_start, b.T_head_start, b.T_head_start);
  if (result) result.T_AB = to_vqs(b.T_head_start);
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
