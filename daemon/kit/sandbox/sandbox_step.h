// SPDX-License-Identifier: Apache-2.0
#pragma once

// The service's side of a stage that runs in its own process.

#include "base/params.h"
#include "image/shared_memory.h"
#include "kit/sandbox/frame_codec.h"
#include "kit/sandbox/supervisor.h"
#include "pipeline/stage.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace sslv::sandbox {

/// Additional parameter of every stage that runs in its own process.
struct DeadlineParams {
  double deadline_ms = 10;
  static constexpr auto fields() {
    return std::tuple{number("deadline_ms", &DeadlineParams::deadline_ms, 0.5, 1000.0, "ms",
                             "how long an image waits for this stage, which runs in a process of its own; "
                             "then it continues without the results")};
  }
};

/// Parameters as sent to the stage's process.
struct SandboxParams {
  std::string json;
  DeadlineParams own;
  std::uint64_t id;  // unique for each set of parameters
};

/// Outcomes of the last kImages images, for the admin.
class SandboxReport {
 public:
  /// kNoRoom: no space for the request, or no memory for the answer, in the service.
  enum class Outcome : std::uint8_t { kDone, kLate, kBad, kNoRoom, kNoProcess };
  static constexpr std::size_t kImages = 512;

  void add(Outcome outcome);
  /// Writes the most severe outcome to `notes`; if nothing failed, the stage's own note.
  void tell(const StageProcess& process, double deadline_ms, StageNotes& notes);
  /// Sets the current note of the stage's process.
  void set_own_note(StageNotes::Kind kind, std::span<const char> text);

 private:
  std::array<Outcome, kImages> last_{};
  std::size_t next_ = 0;
  using Counts = std::array<std::uint32_t, static_cast<std::size_t>(Outcome::kNoProcess) + 1>;
  Counts counts_{kImages};

  struct Told {
    Counts counts{};
    std::uint32_t losses = 0;
    std::uint32_t note = 0;
    bool operator==(const Told&) const = default;
  };
  Told told_;
  StageProcess::Losses losses_;  // the last value that was read successfully
  StageNotes::Kind note_kind_{};
  std::size_t note_length_ = 0;
  std::array<char, StageNotes::kMaxText> note_{};
  std::uint32_t note_number_ = 1;
};

/// A part of a frame that belongs to the library and that the stage uses.
struct SandboxOwnPart {
  std::size_t* place;
  bool is_written, is_updated;
};

template <class Floor>
class SandboxStep final : public Step<Floor> {
 public:
  SandboxStep(const StageNeeds& needs, std::vector<SandboxOwnPart> own_parts,
              std::shared_ptr<StageProcess> process, std::chrono::milliseconds min_deadline = {});
  ~SandboxStep() override;
  SandboxStep(const SandboxStep&) = delete;
  SandboxStep& operator=(const SandboxStep&) = delete;

  /// Waits at most max(deadline_ms, min_deadline) plus a few microseconds. Allocates nothing once its lists
  /// have grown.
  void run(const typename Floor::Inputs& in, const void* params) noexcept override;

 private:
  using Outcome = SandboxReport::Outcome;
  Outcome ask(const typename Floor::Inputs& in, const SandboxParams& params);
  bool write_request(const typename Floor::Inputs& in, const SandboxParams& params);
  bool write_given(const typename Floor::Inputs& in, ByteWriter& writer);
  void write_image(const ImageView& image);
  bool sends_file(const SharedPlace& place);
  bool send_file(const ImageFile& message, int file);
  void forget_files();
  bool wait_for(std::uint32_t request, std::uint32_t generation,
                std::chrono::steady_clock::time_point until) const;
  bool take_answer(typename Floor::Frame& frame);
  bool take_own_parts(typename Floor::Frame& frame, std::span<const std::byte> from);
  void take_note();
  void tell_priority();
  template <class T>
  bool write_if_changed(Constant which, const T& value);
  template <class T>
  bool write_by_id(Constant which, std::uint64_t id, const T& value);

  const StageNeeds needs_;
  const std::vector<SandboxOwnPart> own_parts_;
  const std::shared_ptr<StageProcess> process_;
  const std::chrono::nanoseconds min_deadline_;
  std::uint32_t generation_ = 0;  // generation of the process that got the last request
  std::uint32_t request_ = 0;     // the newest request's number
  bool is_busy_ = false;          // the process still works on request_
  std::array<std::uint64_t, kConstants> sent_ids_{};
  std::unique_ptr<std::byte[]> compared_;  // a constant's encoding, to compare with the one sent before
  struct SentFile {
    std::uint64_t id = 0;
    std::uint32_t used = 0;  // number of the newest request with an image from this file
  };
  std::array<SentFile, kMaxKept> sent_files_{};
  typename Floor::Frame scratch_;  // scratch for decoding and validating an answer
  /// Scratch for one own part: a private copy of its bytes, which the process cannot change any more, and the
  /// decoded object.
  struct OwnScratch {
    std::vector<std::byte> bytes;
    std::shared_ptr<void> part;
    OwnPartCode code;
  };
  std::vector<OwnScratch> own_scratch_;
  SandboxReport report_;
};

}  // namespace sslv::sandbox
