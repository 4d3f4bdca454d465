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

/// A process already read this memory, and then crashed.
struct RingWasRead : ClipError {
  RingWasRead() : ClipError("a service that read it crashed") {}
};

/// Ring buffer of fixed size with the newest frames of one camera, each encoded as a clip block. The camera's
/// thread adds frames: adding copies the image once, allocates nothing, never blocks, and overwrites the
/// oldest frames. One other thread, the keeper, may hold frames until it has written them to a file; held
/// frames are not overwritten.
///
/// The memory is an anonymous file: after a crash, another process that has the file open still finds the
/// frames. The destructor empties the file.
class ImageRing {
 public:
  /// Allocates and populates all memory (0.5 s per GB), so that the camera's thread causes no page faults
  /// later. Throws std::system_error if there is not enough memory, or if `stop` is requested.
  explicit ImageRing(std::size_t bytes, const std::stop_token& stop = {});
  /// Opens the memory of a crashed process, for a keeper; no camera adds frames to it. Any part may be
  /// damaged; damaged parts are left out. Memory can be opened only once: if reading it crashes the service,
  /// the next run does not read it again. Throws RingWasRead, and ClipError if `left` is not the memory of an
  /// ImageRing, if another version wrote it, or if its process ended normally.
  explicit ImageRing(OpenFile left);
  ~ImageRing();
  ImageRing(const ImageRing&) = delete;
  ImageRing& operator=(const ImageRing&) = delete;

  /// For a crashed process's memory: allows the memory to be opened once more, with all frames. The
  /// destructor then does not empty the memory.
  void put_back() noexcept;
  bool is_put_back() const { return is_put_back_; }

  /// Capacity for blocks.
  std::size_t bytes() const { return room_; }
  /// Descriptor of the memory.
  int fd() const { return file_.fd(); }

  /// Summary of the frames in the ring.
  struct Extent {
    std::uint64_t frames = 0;
    std::int64_t oldest_ns = 0, newest_ns = 0;  // arrival on the steady clock; 0: no frames
    std::uint32_t oldest_setup = 0;             // lower bound of the setup numbers in the ring
    std::uint64_t dropped = 0;                  // frames that put() rejected since the ring was created
  };
  /// Callable from any thread.
  Extent extent() const noexcept;

  /// For the camera's thread. False if the frame was dropped: the keeper holds the space, the frame is larger
  /// than the ring, or a clip cannot hold the frame.
  bool put(const ClipFrame& frame) noexcept;

  // The following functions are for the keeper.

  /// Holds the frames that arrived in this time (steady clock): they are not overwritten until released.
  /// Frames that are already held remain held. Call hold() again for later frames.
  void hold(std::int64_t from_ns, std::int64_t to_ns);
  /// Bytes of the blocks of all held frames.
  std::uint64_t held_bytes() const;
  /// The oldest held frame, with arrived_ns; null: none. Valid until the next call of let_go().
  const ClipFrame* oldest_held();
  void let_go();
  void let_all_go();

  /// The setup with this number, as a payload (clip_format.h); empty if the setup is missing or damaged.
  /// Callable from any thread.
  std::vector<std::byte> setup(std::uint32_t number) const;

  // The following functions are for any thread but the camera's, one thread at a time.

  /// Throws ClipError if a clip cannot hold the setup, or if there is no memory.
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
  std::size_t at_ = 0;  // offset of the next frame; used by the camera's thread

  std::deque<std::uint64_t> held_;  // like the next two members, used by the keeper
  std::uint64_t next_to_hold_ = 0;
  ClipFrame oldest_;

  std::deque<std::uint32_t> setups_;  // numbers of the stored setups
};

}  // namespace sslv
