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
inline void take_in(Lookup& lookup, Duration age, LookupStatus status, EdgeId edge) {
  if (status == LookupStatus::ok || !lookup) return;
  if (status == LookupStatus::held && lookup.status == LookupStatus::held && age <= lookup.age) return;
  lookup.status = status;
  lookup.age = age;
  lookup.edge = edge;
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
    detail::RawVqs T_AB;
    const PoseHistory::RawSample sample = e.history.at(t, T_AB);
    detail::take_in(result, sample.age, lookup_status(sample.status), {n.parent_edge, e.generation});
    T_head_start = n.parent_is_A ? product(T_AB, T_head_start) : inverse_product(T_AB, T_head_start);
    const Node& above = graph.node(n.parent);
    if (above.head != n.parent) T_head_start = product(above.T_head_node, T_head_start);
    head = above.head;
  }
};

/// T_root_head at time t, remembered until the time or the graph changes.
inline const FrameGraph::Seen& FrameGraph::from_root(std::int32_t head, HostTime t) const {
  Seen& seen = seen_[static_cast<std::size_t>(head)];
  if (seen.t == t && seen.changes == changes_) return seen;
  const Node& n = node(head);
  seen.t = t;
  seen.changes = changes_;
  if (n.parent < 0) {
    seen = Seen{t, changes_, detail::RawVqs(), Duration(0), LookupStatus::ok, EdgeId()};
    return seen;
  }
  const Node& above = node(n.parent);
  const Seen& up = from_root(above.head, t);
  const Edge& e = edges_[static_cast<std::size_t>(n.parent_edge)];
  detail::RawVqs T_AB;
  const PoseHistory::RawSample sample = e.history.at(t, T_AB);
  Lookup so_far{Vqs(), up.age, up.status, up.edge};
  detail::take_in(so_far, sample.age, lookup_status(sample.status), {n.parent_edge, e.generation});
  seen.age = so_far.age;
  seen.status = so_far.status;
  seen.edge = so_far.edge;
  if (!so_far) return seen;
  if (!n.parent_is_A) T_AB = inverse(T_AB);
  if (above.head != n.parent) T_AB = product(above.T_head_node, T_AB);
  seen.T_root_head = above.head == n.root ? T_AB : product(up.T_root_head, T_AB);
  return seen;
}

/// The way leads through the root's cluster.
inline bool FrameGraph::by_root(const Node& a, const Node& b) {
  return a.branch != b.branch || a.branch < 0;
}

inline Lookup FrameGraph::lookup(FrameId A, FrameId B, HostTime t) const {
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
  if (nA.head == nB.head) {
    if (A != B) result.T_AB = to_vqs(inverse_product(nA.T_head_node, nB.T_head_node));
    return result;
  }
  if (!by_root(nA, nB)) return lookup_below_root(A, B, t);
  const Seen &a = from_root(nA.head, t), &b = from_root(nB.head, t);
  join(a, b, result);
  if (!result) return result;
  // T_AB = (T_root_headA T_headA_A)^-1 (T_root_headB T_headB_B)
  detail::RawVqs T = nB.head == B.index() ? b.T_root_head : product(b.T_root_head, nB.T_head_node);
  T = inverse_product(a.T_root_head, T);
  if (nA.head != A.index()) T = inverse_product(nA.T_head_node, T);
  result.T_AB = to_vqs(T);
  return result;
}

inline void FrameGraph::join(const Seen& a, const Seen& b, Lookup& result) {
  detail::take_in(result, a.age, a.status, a.edge);
  detail::take_in(result, b.age, b.status, b.edge);
}

/// Frames of one branch meet below the root: what is above their meeting must not be asked.
inline Lookup FrameGraph::lookup_below_root(FrameId A, FrameId B, HostTime t) const {
  Lookup result;
  Climb a(*this, A), b(*this, B);
  while (a.head != b.head && result) {
    const bool raise_a = node(a.head).cluster_depth > node(b.head).cluster_depth;
    raise_a ? a.raise(*this, t, result) : b.raise(*this, t, result);
  }
  if (result) result.T_AB = to_vqs(inverse_product(a.T_head_start, b.T_head_start));
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
