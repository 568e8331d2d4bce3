/// The coordinate-system graph: named frames, joined by independent transforms; every other transform follows from
/// those.
///
/// Source: Robinett & Holloway 1994, section 5 (course 11). Each edge is an independent transform T_AB (p_A = T_AB *
/// p_B), static (calibrated once) or dynamic (tracked, flown, grabbed: a PoseHistory). The graph is acyclic: an edge
/// that would make a second way between two frames is refused, and the refusal names both ways. It may be in several
/// components while it is being built; a lookup between components answers `no_path`, and `missing_path` says in words
/// which frames each holds. Several users are several branches below one world frame.
///
/// `lookup(A, B, t)` allocates nothing, locks nothing and throws nothing. Frames joined by static edges form a cluster
/// whose transforms are folded when the graph changes, so that a lookup pays for dynamic edges only; and what one
/// lookup interpolated serves the next of the same time, as both eyes and all objects of a frame have it. Register
/// the world first: it becomes the root, where the ways meet. A Chain (chain.hpp) is a lookup that is resolved once.
///
/// Threads: one. A lookup, though const, writes down what it has seen, so whoever writes (push, add, remove) and
/// whoever looks up must be the same thread or take turns.
///
/// Units: those of the transforms, usually metres. Bad input gets a status and changes nothing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/frames/lookup.hpp>
#include <holdfast/frames/pose_history.hpp>

namespace holdfast {

class Chain;

enum class EdgeKind : std::uint8_t { fixed, dynamic };
enum class EdgeStatus : std::uint8_t { added, unknown_frame, same_frame, second_way, not_finite };

/// What became of an edge that was to be added; `message` is empty when it was.
struct AddedEdge {
  EdgeStatus status = EdgeStatus::added;
  EdgeId edge;
  std::string message;
  explicit operator bool() const { return status == EdgeStatus::added; }
};

/// One edge of a path, as it is met on the way: T_outer_inner, which is the edge's T_AB or, when `inverted`, its
/// inverse.
struct PathStep {
  FrameId outer, inner;
  EdgeId edge;
  bool inverted = false;
};

class FrameGraph {
 public:
  struct Edge {
    FrameId A, B;
    EdgeKind kind = EdgeKind::fixed;
    std::uint32_t generation = 0;
    bool removed = false;
    Vqs T_AB;                                            // static edges
    PoseHistory history{HistoryOptions{.capacity = 1}};  // dynamic edges

    [[nodiscard]] PoseHistory::Sample at(HostTime t) const {
      if (kind == EdgeKind::dynamic) return history.at(t);
      return {T_AB, Duration(0), SampleStatus::interpolated};
    }
  };

  FrameGraph() = default;
  FrameGraph(const FrameGraph&) = delete;  // chains point to their graph
  FrameGraph& operator=(const FrameGraph&) = delete;

  // ---- frames
  // -----------------------------------------------------------------------------------------------------------------

  /// The frame of this name, registered now if it is new. Precondition: the name is not empty.
  FrameId frame(std::string_view name);
  /// The frame of this name if there is one; never registers.
  [[nodiscard]] std::optional<FrameId> find(std::string_view name) const;
  /// Precondition: a frame of this graph.
  [[nodiscard]] const std::string& name(FrameId f) const;
  [[nodiscard]] std::size_t frame_count() const { return nodes_.size(); }
  [[nodiscard]] bool contains(FrameId f) const { return f.index() >= 0 && index(f) < nodes_.size(); }

  // ---- independent transforms
  // ---------------------------------------------------------------------------------------------------

  AddedEdge add_static(FrameId A, FrameId B, const Vqs& T_AB);
  AddedEdge add_dynamic(FrameId A, FrameId B, const HistoryOptions& options = {});
  /// A new value for a static edge (a calibration was loaded). False when the edge is not static or the value is not
  /// finite.
  bool set_static(EdgeId edge, const Vqs& T_AB);
  /// Takes an edge away: its frames fall into two components. False when it is not there.
  bool remove(EdgeId edge);

  /// A new sample T_AB of a dynamic edge at time t; see PoseHistory::push.
  PushStatus push(EdgeId edge, HostTime t, const Vqs& T_AB) {
    PoseHistory* h = history_of(edge);
    ++changes_;
    return h ? h->push(t, T_AB) : PushStatus::not_dynamic;
  }
  PushStatus push(EdgeId edge, HostTime t, const Vqs& T_AB, HostTime now) {
    PoseHistory* h = history_of(edge);
    ++changes_;
    return h ? h->push(t, T_AB, now) : PushStatus::not_dynamic;
  }

  /// The edge, or null when it is not there (any more).
  [[nodiscard]] const Edge* edge(EdgeId id) const {
    if (id.index() < 0 || static_cast<std::size_t>(id.index()) >= edges_.size()) return nullptr;
    const Edge& e = edges_[static_cast<std::size_t>(id.index())];
    return e.removed || e.generation != id.generation() ? nullptr : &e;
  }
  /// All edges that are there, in the order of their slots.
  [[nodiscard]] std::vector<EdgeId> edges() const;

  // ---- dependent transforms
  // -----------------------------------------------------------------------------------------------------

  /// T_AB at time t for any two frames.
  [[nodiscard]] Lookup lookup(FrameId A, FrameId B, HostTime t) const;
  /// The same, resolved once for use every frame; include chain.hpp.
  [[nodiscard]] Chain chain(FrameId A, FrameId B) const;

  [[nodiscard]] bool connected(FrameId A, FrameId B) const {
    return contains(A) && contains(B) && node(A).root == node(B).root;
  }
  /// The edges between A and B, leftmost (A's) first; nothing when there is no path; empty when A is B.
  [[nodiscard]] std::optional<std::vector<PathStep>> path(FrameId A, FrameId B) const;
  /// The frames of each component, in the order of registration.
  [[nodiscard]] std::vector<std::vector<FrameId>> components() const;
  /// Why there is no path between A and B, naming the frames of either component; empty when there is one.
  [[nodiscard]] std::string missing_path(FrameId A, FrameId B) const;
  /// Changes whenever a chain made earlier could be wrong: an edge added, removed or set.
  [[nodiscard]] std::uint64_t version() const { return version_; }

 private:
  struct Node {
    std::int32_t root = -1;    // of its component
    std::int32_t parent = -1;  // towards the root; -1 at the root
    std::int32_t parent_edge = -1;
    std::int32_t depth = 0;              // edges to the root
    std::int32_t head = -1;              // the frame of its static cluster nearest to the root
    std::int32_t cluster_depth = 0;      // dynamic edges to the root
    std::int32_t branch = -1;            // the cluster head just below the root's cluster; -1 in the root's
    bool parent_is_A = true;             // the parent edge is T_parent_child, not T_child_parent
    detail::RawVqs T_head_node = Vqs();  // folded static edges
  };
  /// What a frame was seen to be at the time last asked for.
  struct Seen {
    HostTime t;
    std::uint64_t changes = 0;  // of the graph by then; 0 never
    detail::RawVqs T_root_frame;
    Duration age{0};
    LookupStatus status = LookupStatus::ok;
    EdgeId edge;
    explicit operator bool() const { return status == LookupStatus::ok || status == LookupStatus::held; }
  };
  struct Climb;
  friend class Chain;

  static std::size_t index(FrameId f) { return static_cast<std::size_t>(f.index()); }
  [[nodiscard]] const Node& node(FrameId f) const { return nodes_[index(f)]; }
  [[nodiscard]] const Node& node(std::int32_t i) const { return nodes_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] PoseHistory* history_of(EdgeId id) {
    const Edge* e = edge(id);
    return e && e->kind == EdgeKind::dynamic ? &edges_[static_cast<std::size_t>(id.index())].history : nullptr;
  }
  [[nodiscard]] EdgeId edge_id(std::int32_t i) const { return {i, edges_[static_cast<std::size_t>(i)].generation}; }

  [[nodiscard]] const Seen& from_root(std::int32_t frame, HostTime t) const;
  [[nodiscard]] const Seen& see(std::int32_t frame, HostTime t) const;
  [[nodiscard]] static bool by_root(const Node& a, const Node& b);
  [[nodiscard]] Lookup lookup_by_root(FrameId A, FrameId B, HostTime t) const;
  [[nodiscard]] Lookup lookup_below_root(FrameId A, FrameId B, HostTime t) const;
  void changed_shape() {
    ++version_;
    ++changes_;
  }
  AddedEdge add(Edge edge);
  [[nodiscard]] std::string second_way_message(FrameId A, FrameId B) const;
  [[nodiscard]] std::string names_of_component(FrameId f) const;
  std::int32_t store(Edge edge);
  void hang(std::int32_t child, std::int32_t parent, std::int32_t edge);
  void adopt(std::int32_t child, std::int32_t parent, std::int32_t edge);

  std::vector<Node> nodes_;
  std::vector<Edge> edges_;
  std::vector<std::string> names_;
  std::vector<std::vector<std::int32_t>> edges_at_;  // of each frame
  std::vector<std::int32_t> sizes_;                  // frames of the component, valid at its root
  std::map<std::string, std::int32_t, std::less<>> index_of_;
  std::size_t removed_ = 0;    // slots of edges_ that are free
  std::uint64_t version_ = 0;  // of the shape and the static edges
  std::uint64_t changes_ = 1;  // of anything, samples too
  mutable std::vector<Seen> seen_;
  mutable HostTime asked_t_ = HostTime::min();  // of the newest lookup or chain
};

}  // namespace holdfast

#include <holdfast/frames/detail/graph_build.hpp>
#include <holdfast/frames/detail/graph_lookup.hpp>
