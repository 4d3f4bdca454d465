// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"
#include "clips/clip.h"
#include "clips/ring_layout.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <stop_token>
#include <vector>

namespace sslv {

/// The memory was read before, by a process that did not come to its end.
struct RingWasRead : ClipError {
  RingWasRead() : ClipError("a service that read it crashed") {}
};

/// The newest frames of one camera, in memory of a size that never changes, each as the block that a clip has
/// of it. The camera's thread puts them in, which copies the image once, allocates nothing and waits for
/// nobody; the oldest make room. One other thread, the keeper, may hold frames back until it has written them
/// to a file.
///
/// The memory is a file without a name: another process that has it open too finds the frames there when this
/// one has crashed. It is empty from the destructor on.
class ImageRing {
 public:
  /// Takes the memory and touches all of it, so that the camera's thread is given none by the system later:
  /// that takes .5 s for each GB. Throws std::system_error when there is none, or it is told to stop.
  explicit ImageRing(std::size_t bytes, const std::stop_token& stop = {});
  /// What a process left in its memory when it crashed, for a keeper: no camera puts frames there any more.
  /// Any of it may be damaged; what is not as it must be is left out. Each memory can be taken once, so that
  /// one whose reading crashes the service does not do so again. Throws RingWasRead, and ClipError for what
  /// is no such memory, was left by another version or ended well.
  explicit ImageRing(OpenFile left);
  ~ImageRing();
  ImageRing(const ImageRing&) = delete;
  ImageRing& operator=(const ImageRing&) = delete;

  /// Of memory that a process left: another may take all of it again. Its destructor empties nothing then.
  void put_back() noexcept;
  bool is_put_back() const { return is_put_back_; }

  /// For blocks.
  std::size_t bytes() const { return room_; }
  /// The memory as a file.
  int fd() const { return file_.fd(); }

  /// What all frames of the ring tell together.
  struct Extent {
    std::uint64_t frames = 0;
    std::int64_t oldest_ns = 0, newest_ns = 0;  // when they arrived, on the steady clock; 0: there is none
    std::uint32_t oldest_setup = 0;             // no frame of the ring has an earlier one
    std::uint64_t dropped = 0;  // since the ring was made, because the keeper held all that could have gone
  };
  /// From any thread.
  Extent extent() const noexcept;

  /// For the camera's thread. False when there is no room for it because the keeper holds so much, because it
  /// is larger than the ring, or because a clip cannot hold it.
  bool put(const ClipFrame& frame) noexcept;

  // For the keeper.

  /// The frames that arrived in this time (steady clock) are not overwritten until they are let go. Those
  /// that are held already stay so. May be called again for those that come later.
  void hold(std::int64_t from_ns, std::int64_t to_ns);
  /// Of the blocks of all that are held.
  std::uint64_t held_bytes() const;
  /// The oldest of them, until the next call of let_go(); null: there is none. arrived_ns is set.
  const ClipFrame* oldest_held();
  void let_go();
  void let_all_go();

  /// What frames with this setup number were processed with, as a setup's payload (clip_format.h); empty: it
  /// is not there whole. From any thread.
  std::vector<std::byte> setup(std::uint32_t number) const;

  // For any thread but the camera's, one at a time.

  /// Throws ClipError for one that a clip cannot hold, and where there is no memory.
  void put_setup(std::uint32_t number, const ClipSetup& setup);
  void forget_setups_before(std::uint32_t number);

 private:
  RingHead& head() const { return *reinterpret_cast<RingHead*>(mapped_); }
  RingSlot& slot(std::uint64_t frame) const {
    return reinterpret_cast<RingSlot*>(mapped_ + kRingPage)[frame % kRingSlots];
  }
  std::byte* blocks() const { return mapped_ + kRingBlocksAt; }
  void make_head() noexcept;
  void leave_out_damaged() noexcept;
  void free_setup(std::uint32_t number) const;
  bool make_room(std::size_t begin, std::size_t bytes, bool from_the_start) noexcept;

  const OpenFile file_;
  const std::size_t room_;
  std::byte* mapped_ = nullptr;
  bool is_put_back_ = false;
  std::size_t at_ = 0;  // where the next frame would begin; the camera's thread's

  std::deque<std::uint64_t> held_;  // the keeper's, as is the rest
  std::uint64_t next_to_hold_ = 0;
  ClipFrame oldest_;

  std::deque<std::uint32_t> setups_;  // that are there
};

}  // namespace sslv
