// SPDX-License-Identifier: Apache-2.0
#pragma once

// The service's side of a stage that runs in a process of its own.

#include "base/params.h"
#include "image/shared_memory.h"
#include "kit/apart/frame_codec.h"
#include "kit/apart/supervisor.h"
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

namespace sslv::apart {

/// What every stage that runs apart has besides its own parameters.
struct DeadlineParams {
  double deadline_ms = 10;
  static constexpr auto fields() {
    return std::tuple{number("deadline_ms", &DeadlineParams::deadline_ms, 0.5, 1000.0, "ms",
                             "how long an image waits for this stage, which runs in a process of its own; "
                             "then it goes on without")};
  }
};

/// Parameters as the process reads them.
struct ApartParams {
  std::string json;
  DeadlineParams own;
  std::uint64_t id;  // another one for each
};

/// How it went with the last images, for the admin.
class ApartReport {
 public:
  /// kNoRoom: the service had no room for the request or the answer.
  enum class Outcome : std::uint8_t { kDone, kLate, kBad, kNoRoom, kNoProcess };
  static constexpr std::size_t kImages = 512;

  void add(Outcome outcome);
  /// Says the worst of it in `notes`; what the stage itself has to say when nothing is wrong.
  void tell(const StageProcess& process, double deadline_ms, StageNotes& notes);
  /// What the stage's process has to say now.
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
  StageProcess::Losses losses_;  // as far as they could be read
  StageNotes::Kind note_kind_{};
  std::size_t note_length_ = 0;
  std::array<char, StageNotes::kMaxText> note_{};
  std::uint32_t note_number_ = 1;
};

/// A library's part of one stage.
struct ApartOwnPart {
  std::size_t* place;
  bool is_written, is_updated;
};

template <class Floor>
class ApartStep final : public Step<Floor> {
 public:
  ApartStep(const StageNeeds& needs, std::vector<ApartOwnPart> own_parts,
            std::shared_ptr<StageProcess> process, std::chrono::milliseconds min_deadline = {});
  ~ApartStep() override;
  ApartStep(const ApartStep&) = delete;
  ApartStep& operator=(const ApartStep&) = delete;

  /// Waits at most the parameters' deadline, or the shortest there is, and a few microseconds more. Allocates
  /// nothing once its lists have grown.
  void run(const typename Floor::Inputs& in, const void* params) noexcept override;

 private:
  using Outcome = ApartReport::Outcome;
  Outcome ask(const typename Floor::Inputs& in, const ApartParams& params);
  bool write_request(const typename Floor::Inputs& in, const ApartParams& params);
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
  const std::vector<ApartOwnPart> own_parts_;
  const std::shared_ptr<StageProcess> process_;
  const std::chrono::nanoseconds min_deadline_;
  std::uint32_t generation_ = 0;  // of the process that was asked last
  std::uint32_t request_ = 0;     // the newest
  bool is_busy_ = false;          // with that
  std::array<std::uint64_t, kConstants> sent_ids_{};
  std::unique_ptr<std::byte[]> compared_;  // room to write a constant into, to see whether it has changed
  struct SentFile {
    std::uint64_t id = 0;
    std::uint32_t used = 0;  // the newest request with it
  };
  std::array<SentFile, kMaxKept> sent_files_{};
  typename Floor::Frame scratch_;  // where an answer is looked at before it goes into the frame
  /// Likewise of each own part: its bytes, which do not change any more, and what they are read into.
  struct OwnScratch {
    std::vector<std::byte> bytes;
    std::shared_ptr<void> part;
    OwnPartCode code;
  };
  std::vector<OwnScratch> own_scratch_;
  ApartReport report_;
};

}  // namespace sslv::apart
