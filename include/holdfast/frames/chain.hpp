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
    by_root_ = FrameGraph::by_root(graph.node(A), graph.node(B));
    A_ = A;
    B_ = B;
  }

  /// T_AB at time t.
  [[nodiscard]] Lookup at(HostTime t) const {
    if (!valid()) return refusal();
    return by_root_ ? graph_->lookup_by_root(A_, B_, t) : graph_->lookup_below_root(A_, B_, t);
  }

  /// Edges of the path, and how many of them are dynamic and hence evaluated by `at`.
  [[nodiscard]] std::size_t transforms() const { return transforms_; }
  [[nodiscard]] std::size_t dynamic_transforms() const { return dynamic_; }
  /// False when the graph has changed since, or there was no path: `at` will not give a transform.
  [[nodiscard]] bool valid() const { return status_ == LookupStatus::ok && version_ == graph_->version(); }

 private:
  [[nodiscard]] Lookup refusal() const {
    Lookup result;
    result.status = status_ == LookupStatus::ok ? LookupStatus::stale_chain : status_;
    return result;
  }

  const FrameGraph* graph_ = nullptr;
  std::uint64_t version_ = 0;
  FrameId A_, B_;
  bool by_root_ = false;
  std::size_t dynamic_ = 0;
  std::size_t transforms_ = 0;
  LookupStatus status_ = LookupStatus::no_path;
};

inline Chain FrameGraph::chain(FrameId A, FrameId B) const {
  return Chain(*this, A, B);
}

}  // namespace holdfast
