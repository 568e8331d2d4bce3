/// T_AB of one pair of frames, resolved once and evaluated every frame.
///
/// Source: Robinett & Holloway 1994, section 6.1 (course 11): "the leftmost five transforms are static and can
/// therefore be precomputed once". A Chain keeps the folded static runs at both ends and where its dynamic edges hang,
/// so that `at` neither searches nor checks what cannot have changed. Making one allocates nothing that stays; `at`
/// does not allocate, lock or throw. A chain points to its graph, which must outlive it, and shares its thread. When an
/// edge of the graph is added, removed or set, `at` answers `stale_chain`: make the chain again. New samples do not
/// make it stale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/frames/graph.hpp>

namespace holdfast {

class Chain {
 public:
  /// A chain of no graph; `at` answers no_path.
  Chain() = default;

  /// When there is no path, `at` answers `no_path` or `unknown_frame` as the graph's lookup does.
  Chain(const FrameGraph& graph, FrameId A, FrameId B) : graph_(&graph), version_(graph.version()) {
    if (!graph.contains(A) || !graph.contains(B)) {
      status_ = LookupStatus::unknown_frame;
      return;
    }
    const std::optional<std::vector<PathStep>> path = graph.path(A, B);
    if (!path) return;
    status_ = LookupStatus::ok;
    transforms_ = path->size();
    for (const PathStep& step : *path) dynamic_ += graph.edge(step.edge)->kind == EdgeKind::dynamic;
    const FrameGraph::Node &a = graph.node(A), &b = graph.node(B);
    A_ = {A, a.head, a.head == A.index(), a.T_head_node};
    B_ = {B, b.head, b.head == B.index(), b.T_head_node};
    by_root_ = a.head != b.head && FrameGraph::by_root(a, b);
  }

  /// T_AB at time t.
  [[nodiscard]] Lookup at(HostTime t) const {
    Lookup result;
    result.status = status_;
    if (status_ != LookupStatus::ok) return result;
    if (version_ != graph_->version()) {
      result.status = LookupStatus::stale_chain;
      return result;
    }
    if (!by_root_) return graph_->lookup(A_.frame, B_.frame, t);
    const FrameGraph::Seen &a = graph_->from_root(A_.head, t), &b = graph_->from_root(B_.head, t);
    FrameGraph::join(a, b, result);
    if (!result) return result;
    detail::RawVqs T = B_.is_head ? b.T_root_head : product(b.T_root_head, B_.T_head_end);
    T = inverse_product(a.T_root_head, T);
    if (!A_.is_head) T = inverse_product(A_.T_head_end, T);
    result.T_AB = to_vqs(T);
    return result;
  }

  /// Edges of the path, and how many of them are dynamic and hence evaluated by `at`.
  [[nodiscard]] std::size_t transforms() const { return transforms_; }
  [[nodiscard]] std::size_t dynamic_transforms() const { return dynamic_; }
  /// False when the graph has changed since, or there was no path: `at` will not give a transform.
  [[nodiscard]] bool valid() const { return status_ == LookupStatus::ok && version_ == graph_->version(); }

 private:
  /// One end of the chain: its frame and the static run that joins it to its cluster's head.
  struct End {
    FrameId frame;
    std::int32_t head = -1;
    bool is_head = true;
    detail::RawVqs T_head_end;
  };

  const FrameGraph* graph_ = nullptr;
  std::uint64_t version_ = 0;
  End A_, B_;
  bool by_root_ = false;
  std::size_t dynamic_ = 0;
  std::size_t transforms_ = 0;
  LookupStatus status_ = LookupStatus::no_path;
};

inline Chain FrameGraph::chain(FrameId A, FrameId B) const {
  return Chain(*this, A, B);
}

}  // namespace holdfast
