// SPDX-License-Identifier: Apache-2.0
#pragma once

// The memory shared by the service and a stage's process: one block in each direction, written by one side
// and only read by the other. One request at a time: the service writes it, increments `request` and waits
// until `answer` equals `request`.

#include "base/stage_notes.h"
#include "image/image.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace sslv::sandbox {

/// Data that stays the same for many frames and is sent only when it has changed.
enum class Constant : std::uint8_t { kParams, kScene, kLut, kMask, kPatterns };
inline constexpr std::size_t kConstants = 5;

/// Space for each constant, for the parts of a frame, and for a copied image. Unused pages take no physical
/// memory.
inline constexpr std::size_t kMiB = std::size_t{1} << 20;
inline constexpr std::array<std::size_t, kConstants> kConstantRoom{1 * kMiB, 1 * kMiB, 40 * kMiB, 8 * kMiB,
                                                                   1 * kMiB};
inline constexpr std::size_t kPartsRoom = 32 * kMiB, kImageRoom = 64 * kMiB;

/// The place where a frame's image is stored.
enum class ImageAt : std::uint8_t {
  kNowhere,
  kShared,  // in a shared memory block that was sent over the socket
  kCopied,  // in the channel's image space
};

/// A message over the socket, with the file descriptor of the shared memory block `id` unless `id` is 0. The
/// process unmaps all blocks except `id` and `keep`.
inline constexpr std::size_t kMaxKept = 16;
struct ImageFile {
  std::uint64_t id = 0, bytes = 0;
  std::array<std::uint64_t, kMaxKept> keep{};
};

/// Written by the service.
struct ToStage {
  std::atomic<std::uint32_t> request{0};     // counter; the stage's process waits on this futex
  std::atomic<std::uint32_t> is_waiting{0};  // the service waits on the futex `answer`
  /// Scheduling of the service's waiting thread, see sched(7).
  int policy = 0, priority = 0, nice = 0;
  std::uint32_t files = 0;  // number of ImageFile messages sent over the socket so far

  struct Sent {
    std::uint32_t version = 0;  // changes with each write; 0: not written yet
    std::uint64_t bytes = 0;
  };
  std::array<Sent, kConstants> constants{};

  std::uint64_t parts_bytes = 0;
  double now_s = 0;  // time of the field's clock, in seconds

  ImageAt image_at = ImageAt::kNowhere;
  ImageView image;             // without `data`
  std::uint64_t image_id = 0;  // SharedMemory::id()
  std::uint64_t image_offset = 0;
};

enum class AnswerKind : std::uint32_t {
  kDone = 1,
  kUnreadable,  // the process could not decode the request
  kNoRoom,      // the stage's result is too large
};

/// Written by the stage's process, so it is untrusted and may hold any bytes.
struct FromStage {
  std::atomic<std::uint32_t> answer{0};  // number of the answered request; the service waits on this futex
  std::atomic<std::uint32_t> is_asleep{0};
  AnswerKind kind{};
  std::uint64_t parts_bytes = 0;
  StageNotes::Kind note_kind{};
  std::uint8_t note_length = 0;
  std::array<char, StageNotes::kMaxText> note{};
};

/// Maps both blocks of shared memory.
class Channel {
 public:
  /// For the service: creates the memory. Throws std::system_error.
  Channel();
  /// For the stage's process: maps the service's memory. Throws std::system_error.
  Channel(int to_stage_file, int from_stage_file);
  ~Channel();
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;

  ToStage& to() const { return *reinterpret_cast<ToStage*>(to_); }
  FromStage& from() const { return *reinterpret_cast<FromStage*>(from_); }
  std::span<std::byte> constant(Constant which) const;
  std::span<std::byte> parts_to_stage() const;
  std::span<std::byte> image() const;
  std::span<std::byte> parts_from_stage() const;
  int to_file() const { return to_file_; }
  int from_file() const { return from_file_; }

 private:
  int to_file_ = -1, from_file_ = -1;
  std::byte *to_ = nullptr, *from_ = nullptr;
};

}  // namespace sslv::sandbox
