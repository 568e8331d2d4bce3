/// Threads that wait for work: made once, woken for each frame, without locks or memory of their own.
///
/// run(items, task) calls task(i) once for every i in [0, items) and returns when all are done. The calling thread
/// takes part. Items are dealt one by one to whoever is free, so that a thread that is held up costs little. Threads
/// that wake too late to find work are not waited for. One run at a time; the task must not throw.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include <holdfast/assert.hpp>

namespace holdfast::detail {

class WorkerPool {
 public:
  /// `threads` counts the calling one: 1 makes no further ones.
  explicit WorkerPool(int threads)
      : threads_(threads), ranges_(std::make_unique<Range[]>(static_cast<std::size_t>(threads))) {
    HOLDFAST_ASSERT(threads >= 1, "work needs a thread");
    workers_.reserve(static_cast<std::size_t>(threads - 1));
    try {
      for (int i = 1; i < threads; ++i) workers_.emplace_back([this, i] { serve(i); });
    } catch (...) {  // no more threads to be had: those that run must end before we may go
      stop();
      throw;
    }
  }
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  [[nodiscard]] int threads() const { return threads_; }

  template <typename Task>
  void run(int items, const Task& task) {
    if (workers_.empty() || items <= 1) {
      for (int i = 0; i < items; ++i) task(i);
      return;
    }
    call_ = [](const void* context, int item) { (*static_cast<const Task*>(context))(item); };
    context_ = &task;
    for (int i = 0; i < threads_; ++i) {
      ranges_[i].next.store(part(items, i), std::memory_order_relaxed);
      ranges_[i].end = part(items, i + 1);
    }
    gate_.store(open, std::memory_order_release);
    frame_.fetch_add(1, std::memory_order_release);
    frame_.notify_all();
    work(0);
    // Nobody may enter any more; those inside finish the item they hold.
    std::uint32_t inside = gate_.fetch_and(~open, std::memory_order_acq_rel) & ~open;
    for (int spins = 0; inside != 0; inside = gate_.load(std::memory_order_acquire)) {
      if (++spins > 2000) gate_.wait(inside, std::memory_order_acquire);
    }
  }

 private:
  static constexpr std::uint32_t open = 0x80000000U;

  struct alignas(64) Range {
    std::atomic<int> next{0};
    int end = 0;
  };

  /// Where the range of thread i begins.
  [[nodiscard]] int part(int items, int i) const {
    return static_cast<int>(static_cast<std::int64_t>(items) * i / threads_);
  }

  void work(int thread) {
    for (int i = 0; i < threads_; ++i) {
      Range& range = ranges_[(thread + i) % threads_];
      for (int item = take(range); item < range.end; item = take(range)) call_(context_, item);
    }
  }

  [[nodiscard]] static int take(Range& range) {
    // Ask before adding: what was emptied long ago must not be counted up for ever.
    if (range.next.load(std::memory_order_relaxed) >= range.end) return range.end;
    return range.next.fetch_add(1, std::memory_order_relaxed);
  }

  [[nodiscard]] bool enter() {
    std::uint32_t gate = gate_.load(std::memory_order_relaxed);
    while ((gate & open) != 0U) {
      if (gate_.compare_exchange_weak(gate, gate + 1, std::memory_order_acquire, std::memory_order_relaxed))
        return true;
    }
    return false;
  }

  void serve(int thread) {
    for (std::uint32_t seen = 0;;) {
      frame_.wait(seen, std::memory_order_acquire);
      seen = frame_.load(std::memory_order_acquire);
      if (stop_.load(std::memory_order_acquire)) return;
      if (!enter()) continue;
      work(thread);
      if (gate_.fetch_sub(1, std::memory_order_acq_rel) == 1) gate_.notify_all();
    }
  }

  void stop() {
    stop_.store(true, std::memory_order_release);
    frame_.fetch_add(1, std::memory_order_release);
    frame_.notify_all();
    for (std::thread& worker : workers_) worker.join();
    workers_.clear();
  }

  int threads_;
  // Written by run() while the gate is shut, read by those who passed it.
  void (*call_)(const void*, int) = nullptr;
  const void* context_ = nullptr;
  std::unique_ptr<Range[]> ranges_;  ///< of each thread

  std::atomic<std::uint32_t> gate_{0};   ///< `open` and the number of workers inside
  std::atomic<std::uint32_t> frame_{0};  ///< counts the calls of run
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace holdfast::detail
