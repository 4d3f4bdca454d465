// SPDX-License-Identifier: Apache-2.0
#pragma once

// The memory that the service and a stage's process share: what one writes and the other only reads, each
// way. One request at a time: the service writes it, counts `request` up and waits until `answer` is the
// same.

#include "image/image.h"
#include "pipeline/stage_notes.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace sslv::apart {

/// What stays for many frames, and is sent only when it has changed.
enum class Constant : std::uint8_t { kParams, kScene, kLut, kMask, kPatterns };
inline constexpr std::size_t kConstants = 5;

/// Room for each, and for the parts of a frame. What is not used takes no real memory.
inline constexpr std::size_t kMiB = std::size_t{1} << 20;
inline constexpr std::array<std::size_t, kConstants> kConstantRoom{1 * kMiB, 1 * kMiB, 40 * kMiB, 8 * kMiB,
                                                                   1 * kMiB};
inline constexpr std::size_t kPartsRoom = 32 * kMiB, kImageRoom = 64 * kMiB;

/// Where a frame's image lies.
enum class ImageAt : std::uint8_t {
  kNowhere,
  kShared,  // in memory that was sent over the socket
  kCopied,  // here, in the room for it
};

/// A message over the socket, with the file of `id` unless that is 0. The process keeps no other memory than
/// that and `keep`.
inline constexpr std::size_t kMaxKept = 16;
struct ImageFile {
  std::uint64_t id = 0, bytes = 0;
  std::array<std::uint64_t, kMaxKept> keep{};
};

/// Written by the service.
struct ToStage {
  std::atomic<std::uint32_t> request{0};     // counts; the stage's process waits here
  std::atomic<std::uint32_t> is_waiting{0};  // the service sleeps at `answer`
  /// Of the thread that waits, as sched(7).
  int policy = 0, priority = 0, nice = 0;
  std::uint32_t files = 0;  // how many ImageFile messages were sent over the socket so far

  struct Sent {
    std::uint32_t version = 0;  // another number for each that was sent; 0: none was
    std::uint64_t bytes = 0;
  };
  std::array<Sent, kConstants> constants{};

  std::uint64_t parts_bytes = 0;
  double now_s = 0;  // of the field's clock

  ImageAt image_at = ImageAt::kNowhere;
  ImageView image;             // but for `data`
  std::uint64_t image_id = 0;  // SharedMemory::id()
  std::uint64_t image_offset = 0;
};

enum class AnswerKind : std::uint32_t {
  kDone = 1,
  kUnreadable,  // the process does not understand the request
  kNoRoom,      // what the stage made is too large
};

/// Written by the stage's process, so it may hold anything.
struct FromStage {
  std::atomic<std::uint32_t> answer{0};  // the request that it answers; the service waits here
  std::atomic<std::uint32_t> is_asleep{0};
  AnswerKind kind{};
  std::uint64_t parts_bytes = 0;
  StageNotes::Kind note_kind{};
  std::uint8_t note_length = 0;
  std::array<char, StageNotes::kMaxText> note{};
};

/// Both memories, mapped.
class Channel {
 public:
  /// For the service: makes them. Throws std::system_error.
  Channel();
  /// For the stage's process: of the service. Throws std::system_error.
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

}  // namespace sslv::apart
