/// The newest of a stream of fixed-size records, from one writing thread to any number of reading ones.
///
/// A record is `Words` 64-bit words, copied word by word through atomics: no data race in the sense of the C++ memory
/// model, hence nothing for ThreadSanitizer to forgive, and no fences. There are `Slots` slots. The writer fills the
/// slot after the newest and then names it the newest; a reader copies the newest slot and keeps the copy if the slot's
/// number is unchanged before and after (a sequence lock per slot: Boehm 2012, Can seqlocks get along with programming
/// language memory models?).
///
/// Progress: the writer never waits, for anyone. A reader never waits for the writer: one that is paused in the middle
/// of a write holds only a slot that nobody reads yet. A reader must copy anew only if the writer completed Slots - 1
/// further records during its one copy, that is if the reader itself was paused so long; it gives up after `attempts`
/// copies in a row. So a write is wait-free, and a read ends within a bounded number of steps, all but certainly with a
/// record. Nothing allocates, locks or throws where std::atomic<std::uint64_t> is lock-free, which is asserted.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace holdfast::detail {

enum class WordsRead {
  ok,
  nothing_yet,  ///< no record was written
  overtaken     ///< the writer was faster than every attempt to copy
};

template <std::size_t Words, std::size_t Slots>
class NewestWords {
  static_assert(Slots >= 2, "the newest record must survive while the next is written");
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  using Record = std::array<std::uint64_t, Words>;
  static constexpr int attempts = 64;

  /// From one thread at a time.
  void write(const Record& record) {
    begin_write();
    Slot& slot = slots_[written_ % Slots];
    // Release: a reader that sees one of these words also sees that the slot is being written.
    for (std::size_t i = 0; i < Words; ++i) slot.words[i].store(record[i], std::memory_order_release);
    end_write();
  }

  [[nodiscard]] WordsRead read(Record& record) const {
    for (int attempt = 0; attempt < attempts; ++attempt) {
      const std::uint64_t number = newest_.load(std::memory_order_acquire);
      if (number == 0) return WordsRead::nothing_yet;
      const Slot& slot = slots_[number % Slots];
      if (slot.number.load(std::memory_order_acquire) != number) continue;
      for (std::size_t i = 0; i < Words; ++i) record[i] = slot.words[i].load(std::memory_order_acquire);
      if (slot.number.load(std::memory_order_relaxed) == number) return WordsRead::ok;
    }
    return WordsRead::overtaken;
  }

  /// Records written so far.
  [[nodiscard]] std::uint64_t count() const { return newest_.load(std::memory_order_acquire); }

 private:
  static constexpr std::uint64_t being_written = 0;  // numbers of records start at 1

  struct alignas(64) Slot {
    std::atomic<std::uint64_t> number{being_written};
    std::array<std::atomic<std::uint64_t>, Words> words{};
  };

  /// The two ends of a write, apart so that a test can stop in between.
  void begin_write() { slots_[++written_ % Slots].number.store(being_written, std::memory_order_relaxed); }
  void end_write() {
    slots_[written_ % Slots].number.store(written_, std::memory_order_release);
    newest_.store(written_, std::memory_order_release);
  }
  friend struct NewestWordsTestAccess;

  std::array<Slot, Slots> slots_{};
  alignas(64) std::atomic<std::uint64_t> newest_{0};
  alignas(64) std::uint64_t written_ = 0;  // the writer's own
};

}  // namespace holdfast::detail
