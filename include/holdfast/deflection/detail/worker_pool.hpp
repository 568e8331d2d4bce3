/// Threads that wait for work: made once, woken for each frame, without locks or memory of their own.
///
/// run(items, task) calls task(i) once for every i in [0, items) and returns when all are done. The calling thread
/// takes part. Items are dealt one by one to whoever is free, so that a thread that is held up costs little. Threads
/// that wake too late to find work are not waited for. One run at a time; the task must not throw.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include <holdfast/assert.hpp>

namespace holdfast::detail {

class WorkerPool {
 public:
  /// `threads` counts the calling one: 1 makes no further ones.
  explicit WorkerPool(int threads) {
    HOLDFAST_ASSERT(threads >= 1, "work needs a thread");
    workers_.reserve(static_cast<std::size_t>(threads - 1));
    try {
      for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { serve(); });
    } catch (...) {  // no more threads to be had: those that run must end before we may go
      stop();
      throw;
    }
  }
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  [[nodiscard]] int threads() const { return static_cast<int>(workers_.size()) + 1; }

  template <typename Task>
  void run(int items, const Task& task) {
    if (workers_.empty() || items <= 1) {
      for (int i = 0; i < items; ++i) task(i);
      return;
    }
    call_ = [](const void* context, int item) { (*static_cast<const Task*>(context))(item); };
    context_ = &task;
    items_ = items;
    next_.store(0, std::memory_order_relaxed);
    gate_.store(open, std::memory_order_release);
    frame_.fetch_add(1, std::memory_order_release);
    frame_.notify_all();
    work();
    // Nobody may enter any more; those inside finish the item they hold.
    std::uint32_t inside = gate_.fetch_and(~open, std::memory_order_acq_rel) & ~open;
    for (int spins = 0; inside != 0; inside = gate_.load(std::memory_order_acquire)) {
      if (++spins > 2000) gate_.wait(inside, std::memory_order_acquire);
    }
  }

 private:
  static constexpr std::uint32_t open = 0x80000000U;

  void work() {
    for (int i = next_.fetch_add(1, std::memory_order_relaxed); i < items_;
         i = next_.fetch_add(1, std::memory_order_relaxed)) {
      call_(context_, i);
    }
  }

  [[nodiscard]] bool enter() {
    std::uint32_t gate = gate_.load(std::memory_order_relaxed);
    while ((gate & open) != 0U) {
      if (gate_.compare_exchange_weak(gate, gate + 1, std::memory_order_acquire, std::memory_order_relaxed))
        return true;
    }
    return false;
  }

  void serve() {
    for (std::uint32_t seen = 0;;) {
      frame_.wait(seen, std::memory_order_acquire);
      seen = frame_.load(std::memory_order_acquire);
      if (stop_.load(std::memory_order_acquire)) return;
      if (!enter()) continue;
      work();
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

  // Written by run() while the gate is shut, read by those who passed it.
  void (*call_)(const void*, int) = nullptr;
  const void* context_ = nullptr;
  int items_ = 0;

  std::atomic<int> next_{0};
  std::atomic<std::uint32_t> gate_{0};   ///< `open` and the number of workers inside
  std::atomic<std::uint32_t> frame_{0};  ///< counts the calls of run
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace holdfast::detail
