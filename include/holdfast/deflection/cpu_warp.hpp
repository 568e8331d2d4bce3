/// The composed warp on the CPU: a finished source picture to what the panel must show, lens and late correction in one
/// pass, at the definition of ComposedWarp.
///
///     WarpLattice lattice(eye, LensMode::exact);                      // once an eye
///     CpuWarp warp;                                                   // once: owns its threads
///     warp.draw(lattice, ComposedWarp(...), source, target);          // each frame
///
/// Where a panel pixel finds its source pixel is computed on the fly: lens from the lattice (per colour when colours
/// are bent differently), then H_SE of the pixel's line. Pictures are RGBA, 8 bits or float a channel, of any sizes and
/// strides; the target is as large as the panel, the source as large as its RenderedView says. Filters: bilinear and
/// Catmull-Rom. What has no source (outside the source picture's rectangle in any colour, outside the lens's domain,
/// behind the source eye) gets the border's colour, transparent black by default, so that alpha is the mask of what is
/// covered when the source is opaque. Alpha comes from green's place. A warp by depth is searched pixel by pixel in
/// double precision, as its definition says, and takes far longer; what it reveals gets the search's guess. Tiles are
/// dealt to threads as they get free; with AVX2 and FMA, found out at run time, the work is done in vectors, else in
/// portable code that gives the same within 1/255. The number of threads changes no bit. draw() neither allocates, locks
/// nor throws, but for the first time that a target is larger than all before. One draw at a time for each CpuWarp. The
/// C++ library's threads may want -pthread. Bad input: refused with a CpuWarpProblem; the target stays as it was.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <thread>
#include <type_traits>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/detail/scan_lines.hpp>
#include <holdfast/deflection/detail/warp_frame.hpp>
#include <holdfast/deflection/detail/warp_kernels.hpp>
#include <holdfast/deflection/detail/warp_source.hpp>
#include <holdfast/deflection/detail/worker_pool.hpp>
#include <holdfast/deflection/picture_span.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/deflection/warp_lattice.hpp>

namespace holdfast {

enum class CpuWarpProblem {
  none,
  source_picture,  ///< see problem_of(source)
  target_picture,  ///< see problem_of(target)
  source_size,     ///< not the size that its RenderedView names
  target_size,     ///< not the size of the panel
  other_lens,      ///< the lattice was prepared for another panel, lens or LensMode
  other_view,      ///< the picture was drawn with another view than the warp is for
  overlap,         ///< source and target share memory
  not_finite,      ///< the view or H_SE holds numbers that are not
};

[[nodiscard]] constexpr std::string_view describe(CpuWarpProblem problem) {
  switch (problem) {
    case CpuWarpProblem::none:
      return "the picture can be warped";
    case CpuWarpProblem::source_picture:
      return "the source picture is null, empty, too large, or its stride is below four times its width";
    case CpuWarpProblem::target_picture:
      return "the target picture is null, empty, too large, or its stride is below four times its width";
    case CpuWarpProblem::source_size:
      return "the source picture's size is not that of its RenderedView";
    case CpuWarpProblem::target_size:
      return "the target picture's size is not that of the eye's panel";
    case CpuWarpProblem::other_lens:
      return "the lattice was prepared for another panel, lens or lens mode";
    case CpuWarpProblem::other_view:
      return "the source picture was drawn with another view than the warp is for";
    case CpuWarpProblem::overlap:
      return "the source and target pictures share memory";
    case CpuWarpProblem::not_finite:
      return "the view or the homography is not finite";
  }
  return "unknown problem";
}

struct CpuWarpOptions {
  int threads = 0;  ///< with the calling one; 0: as many as the machine runs at once
  WarpFilter filter = WarpFilter::bilinear;
  bool vectors = true;  ///< use vector code where the processor has it
};

class CpuWarp {
 public:
  explicit CpuWarp(const CpuWarpOptions& options = {})
      : filter_(options.filter),
        vectors_(options.vectors && detail::has_avx2()),
        pool_(options.threads > 0 ? options.threads
                                  : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {}

  [[nodiscard]] int threads() const { return pool_.threads(); }
  [[nodiscard]] WarpFilter filter() const { return filter_; }
  /// Whether vector code is used.
  [[nodiscard]] bool vectors() const { return vectors_; }

  /// Draws all of `target`; Channel is std::uint8_t or float.
  template <typename Channel>
  CpuWarpProblem draw(const WarpLattice& lattice, const ComposedWarp& warp,
                      const std::type_identity_t<PictureSpan<const Channel>>& source,
                      const PictureSpan<Channel>& target,
                      const std::type_identity_t<std::array<Channel, 4>>& border = {}) {
    const CpuWarpProblem problem = problem_of(lattice, warp, source, target);
    if (problem != CpuWarpProblem::none) return problem;
    const bool by_depth = warp.depth() != nullptr;
    if (!by_depth && !lines_.prepare(warp, lattice.is_linear())) return CpuWarpProblem::not_finite;
    detail::WarpFrame<Channel> frame;
    frame.lattice = &lattice;
    frame.lines = &lines_;
    frame.by_depth = by_depth ? &warp : nullptr;
    frame.source = {source.data, source.stride, source.width, source.height, border};
    frame.target = target;
    frame.positions = detail::position_kernels(vectors_);
    frame.sample = detail::sample_kernel<Channel>(filter_, vectors_);
    frame.sample_colors = detail::sample_colors_kernel<Channel>(filter_, vectors_);
    frame.finish = detail::finish_kernel(vectors_);
    frame.stream = bytes(target) >= stream_bytes;
    pool_.run(frame.tiles(), [&frame](int tile) { frame.draw_tile(tile); });
    return CpuWarpProblem::none;
  }

  /// The same from a picture that knows its view, which must be the one that the warp is for.
  template <typename Picture, typename Channel>
  CpuWarpProblem draw(const WarpLattice& lattice, const ComposedWarp& warp, const RenderedPicture<Picture>& source,
                      const PictureSpan<Channel>& target,
                      const std::type_identity_t<std::array<Channel, 4>>& border = {}) {
    if (!is_same(source.view(), warp.view())) return CpuWarpProblem::other_view;
    return draw<Channel>(lattice, warp, source.picture(), target, border);
  }

 private:
  /// Targets from this size on are written past the caches: no cache near a core holds them until they are read.
  static constexpr std::ptrdiff_t stream_bytes = std::ptrdiff_t{4} << 20;

  template <typename Channel>
  [[nodiscard]] static std::ptrdiff_t bytes(const PictureSpan<Channel>& picture) {
    return 4 * static_cast<std::ptrdiff_t>(sizeof(Channel)) * picture.width * picture.height;
  }

  [[nodiscard]] static bool is_same(const RenderedView& a, const RenderedView& b) {
    return a.size == b.size && a.tangents == b.tangents && a.t == b.t && a.X_WS.p() == b.X_WS.p() &&
           a.X_WS.q().coeffs() == b.X_WS.q().coeffs();
  }

  template <typename Channel>
  [[nodiscard]] static CpuWarpProblem problem_of(const WarpLattice& lattice, const ComposedWarp& warp,
                                                 const PictureSpan<const Channel>& source,
                                                 const PictureSpan<Channel>& target) {
    if (holdfast::problem_of(source) != PictureProblem::none) return CpuWarpProblem::source_picture;
    if (holdfast::problem_of(target) != PictureProblem::none) return CpuWarpProblem::target_picture;
    if (PixelSize{source.width, source.height} != warp.view().size) return CpuWarpProblem::source_size;
    if (PixelSize{target.width, target.height} != warp.eye().resolution) return CpuWarpProblem::target_size;
    if (!lattice.is_for(warp.eye(), warp.mode())) return CpuWarpProblem::other_lens;
    return overlap(source, target) ? CpuWarpProblem::overlap : CpuWarpProblem::none;
  }

  WarpFilter filter_;
  bool vectors_;
  detail::ScanLines lines_;
  detail::WorkerPool pool_;
};

}  // namespace holdfast
