/// The parts of FrameGraph (graph.hpp) that change its shape: registering frames, adding and removing edges.
///
/// Each component is a tree hung from a root. Adding an edge hangs the smaller component from the larger one; removing
/// one makes the part below it a component of its own. Both cost the frames of the part that is hung anew. These may
/// allocate.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <holdfast/frames/graph.hpp>

namespace holdfast {

inline FrameId FrameGraph::frame(std::string_view name) {
  HOLDFAST_ASSERT(!name.empty(), "a frame needs a name");
  if (const std::optional<FrameId> known = find(name)) return *known;
  const std::int32_t i = static_cast<std::int32_t>(nodes_.size());
  Node node;
  node.root = node.head = i;
  nodes_.push_back(node);
  names_.emplace_back(name);
  edges_at_.emplace_back();
  sizes_.push_back(1);
  seen_.emplace_back();
  index_of_.emplace(std::string(name), i);
  return FrameId(i);
}

inline std::optional<FrameId> FrameGraph::find(std::string_view name) const {
  const auto found = index_of_.find(name);
  if (found == index_of_.end()) return std::nullopt;
  return FrameId(found->second);
}

inline const std::string& FrameGraph::name(FrameId f) const {
  HOLDFAST_ASSERT(contains(f), "the frame is not of this graph");
  return names_[index(f)];
}

inline AddedEdge FrameGraph::add_static(FrameId A, FrameId B, const Vqs& T_AB) {
  if (!T_AB.is_finite() || !(T_AB.s() > 0)) {
    return {
        EdgeStatus::not_finite, {}, "the transform has a number that is not finite, or a scale that is not positive"};
  }
  Edge edge;
  edge.A = A;
  edge.B = B;
  edge.T_AB = T_AB;
  return add(std::move(edge));
}

inline AddedEdge FrameGraph::add_dynamic(FrameId A, FrameId B, const HistoryOptions& options) {
  Edge edge;
  edge.A = A;
  edge.B = B;
  edge.kind = EdgeKind::dynamic;
  edge.history = PoseHistory(options);
  return add(std::move(edge));
}

inline AddedEdge FrameGraph::add(Edge edge) {
  const FrameId A = edge.A, B = edge.B;
  if (!contains(A) || !contains(B)) {
    return {EdgeStatus::unknown_frame, {}, "the edge names a frame that is not of this graph"};
  }
  if (A == B) return {EdgeStatus::same_frame, {}, "the edge would join " + name(A) + " to itself"};
  if (connected(A, B)) return {EdgeStatus::second_way, {}, second_way_message(A, B)};

  const std::int32_t e = store(std::move(edge));
  const std::size_t root_A = static_cast<std::size_t>(node(A).root), root_B = static_cast<std::size_t>(node(B).root);
  // The larger stays; of equals the one registered first, which is how a world comes to be the root.
  const bool hang_B = sizes_[root_A] != sizes_[root_B] ? sizes_[root_A] > sizes_[root_B] : root_A < root_B;
  const std::int32_t all = sizes_[root_A] + sizes_[root_B];
  hang_B ? hang(B.index(), A.index(), e) : hang(A.index(), B.index(), e);
  edges_at_[index(A)].push_back(e);
  edges_at_[index(B)].push_back(e);
  sizes_[hang_B ? root_A : root_B] = all;
  changed_shape();
  return {EdgeStatus::added, edge_id(e), {}};
}

inline std::int32_t FrameGraph::store(Edge edge) {
  for (std::size_t i = 0; i < edges_.size() && removed_ > 0; ++i) {
    if (!edges_[i].removed) continue;
    edge.generation = edges_[i].generation + 1;
    edges_[i] = std::move(edge);
    --removed_;
    return static_cast<std::int32_t>(i);
  }
  edges_.push_back(std::move(edge));
  return static_cast<std::int32_t>(edges_.size()) - 1;
}

/// Sets one node from its parent's values.
inline void FrameGraph::adopt(std::int32_t child, std::int32_t parent, std::int32_t e) {
  Node& c = nodes_[static_cast<std::size_t>(child)];
  c.parent = parent;
  c.parent_edge = e;
  if (parent < 0) {
    c.root = c.head = child;
    c.depth = c.cluster_depth = 0;
    c.branch = -1;
    c.T_head_node = Vqs();
    return;
  }
  const Edge& edge = edges_[static_cast<std::size_t>(e)];
  const Node& p = node(parent);
  const bool is_static = edge.kind == EdgeKind::fixed;
  c.parent_is_A = edge.A.index() == parent;
  c.root = p.root;
  c.depth = p.depth + 1;
  c.head = is_static ? p.head : child;
  c.cluster_depth = p.cluster_depth + (is_static ? 0 : 1);
  c.branch = is_static || p.branch >= 0 ? p.branch : child;
  c.T_head_node = Vqs();
  if (!is_static) return;
  const Vqs T_parent_child = c.parent_is_A ? edge.T_AB : edge.T_AB.inverse();
  multiply(p.T_head_node, T_parent_child, c.T_head_node);
  c.T_head_node = to_vqs(c.T_head_node);
}

/// Hangs the tree that `child` is in, with `child` on top, from `parent` (-1: it becomes a root) by the edge.
inline void FrameGraph::hang(std::int32_t child, std::int32_t parent, std::int32_t e) {
  adopt(child, parent, e);
  std::int32_t hung = 1;
  std::vector<std::int32_t> below{child};
  while (!below.empty()) {
    const std::int32_t p = below.back();
    below.pop_back();
    for (const std::int32_t next : edges_at_[static_cast<std::size_t>(p)]) {
      if (next == node(p).parent_edge) continue;
      const Edge& edge = edges_[static_cast<std::size_t>(next)];
      const std::int32_t c = edge.A.index() == p ? edge.B.index() : edge.A.index();
      adopt(c, p, next);
      below.push_back(c);
      ++hung;
    }
  }
  if (parent < 0) sizes_[static_cast<std::size_t>(child)] = hung;
}

inline bool FrameGraph::set_static(EdgeId id, const Vqs& T_AB) {
  const Edge* e = edge(id);
  if (!e || e->kind != EdgeKind::fixed || !T_AB.is_finite() || !(T_AB.s() > 0)) return false;
  edges_[static_cast<std::size_t>(id.index())].T_AB = T_AB;
  const bool B_below = node(e->B).parent_edge == id.index();
  const FrameId child = B_below ? e->B : e->A, parent = B_below ? e->A : e->B;
  hang(child.index(), parent.index(), id.index());
  changed_shape();
  return true;
}

inline bool FrameGraph::remove(EdgeId id) {
  const Edge* e = edge(id);
  if (!e) return false;
  const FrameId A = e->A, B = e->B;
  const std::int32_t child = node(B).parent_edge == id.index() ? B.index() : A.index();
  const std::size_t root = static_cast<std::size_t>(node(A).root);
  std::erase(edges_at_[index(A)], id.index());
  std::erase(edges_at_[index(B)], id.index());
  hang(child, -1, -1);
  sizes_[root] -= sizes_[static_cast<std::size_t>(child)];
  Edge gone;
  gone.generation = id.generation();
  gone.removed = true;
  edges_[static_cast<std::size_t>(id.index())] = std::move(gone);
  ++removed_;
  changed_shape();
  return true;
}

inline std::vector<EdgeId> FrameGraph::edges() const {
  std::vector<EdgeId> ids;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (!edges_[i].removed) ids.push_back(edge_id(static_cast<std::int32_t>(i)));
  }
  return ids;
}

}  // namespace holdfast
