// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_clip.h"

#include "net/parse.h"
#include "net/vision_sender.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace sslv {

/// Makes and keeps a frame's packet, like DetectionSender.
struct ClipReplay::Sink : DetectionSink {
  Sink() { buffer.reserve(kMaxDatagramBytes); }

  /// Sets t_sent_s from the live packet, or from the capture time if there is none.
  void begin(const ClipFrame& recorded) {
    packet = {};
    t_sent_s = recorded.info.times.t_capture_s;
    if (!recorded.packet.empty() && parse(live, recorded.packet) && live.has_detection())
      t_sent_s = live.detection().t_sent();
  }
  void publish(const FrameInfo& info, const Scene&, const RobotList& robots,
               const BallList& balls) noexcept override {
    write_detection(info, robots, balls, t_sent_s, message);
    packet = serialize(message, buffer);
  }

  SSL_WrapperPacket live, message;
  std::vector<std::byte> buffer;
  std::span<const std::byte> packet;
  double t_sent_s = 0;
};

namespace {

const ClipReader::Camera& camera_in(const ClipReader& clip, std::uint32_t camera_id) {
  if (const ClipReader::Camera* camera = clip.camera(camera_id)) return *camera;
  std::string known;
  for (const ClipReader::Camera& camera : clip.cameras())
    known += (known.empty() ? "" : ", ") + std::to_string(camera.id);
  throw ClipError(
      fmt::format("the clip has no camera {}; it has {}", camera_id, known.empty() ? "none" : known));
}

}  // namespace

ClipReplay::ClipReplay(ClipReader& clip, std::uint32_t camera_id, const ClipSpan& span,
                       std::optional<OtherSetup> other)
    : clip_(clip),
      camera_(camera_in(clip, camera_id)),
      camera_id_(camera_id),
      other_(std::move(other)),
      sink_(std::make_unique<Sink>()) {
  const auto& entries = clip_.entries();
  const double begin_s = entries.empty() ? 0 : entries.front().t_capture_s;
  from_s_ = span.from_s > 0 ? begin_s + span.from_s : -std::numeric_limits<double>::infinity();
  to_s_ = span.to_s ? begin_s + *span.to_s : std::numeric_limits<double>::infinity();
  // Start at the last frame, up to the span's begin, for which the clip has the stages' state.
  for (std::size_t i = 0; i < camera_.frames.size(); ++i) {
    const ClipReader::Entry& entry = entries[camera_.frames[i]];
    if (entry.has_memory && entry.t_capture_s <= from_s_) next_ = i;
  }
}

ClipReplay::~ClipReplay() = default;

bool ClipReplay::next(Result& result) {
  while (next_ < camera_.frames.size()) {
    const std::size_t place = camera_.frames[next_];
    const double t_s = clip_.entries()[place].t_capture_s;
    if (t_s > to_s_) break;
    ++next_;
    const ClipFrame& recorded = clip_.read(place);
    if (recorded.image.empty()) {
      doubt("image", fmt::format("frame {} has no complete image", recorded.info.number));
      continue;
    }
    if (recorded.setup != setup_index_) use_setup(recorded.setup);
    follow_memory(recorded);
    sink_->begin(recorded);
    pipeline_->set_next_number(recorded.info.number);
    const Frame& frame = pipeline_->process(Image(recorded.image, nullptr, nullptr, nullptr),
                                            recorded.info.times, recorded.info.whole);
    ++processed_;
    if (t_s < from_s_) continue;
    result = {place, &recorded, &frame, sink_->packet, memory_is_live_ && !other_};
    return true;
  }
  return false;
}

void ClipReplay::use_setup(std::uint32_t setup) {
  if (setup >= clip_.setup_count())
    throw ClipError(fmt::format("the clip has no setup {}, which a frame refers to", setup));
  const ClipSetup clip = clip_.setup(setup);
  const std::string path = fmt::format("the clip's setup {}", setup);
  setup_ = other_ ? setup_with(*other_, clip, setup_.pipeline, path) : setup_of(clip, setup_.pipeline, path);
  setup_index_ = setup;
  if (pipeline_) {
    pipeline_->change(setup_);
  } else {
    pipeline_ = std::make_unique<CameraPipeline>(camera_id_, *sink_, setup_);
  }
}

void ClipReplay::follow_memory(const ClipFrame& recorded) {
  const std::uint32_t number = recorded.info.number;
  const bool is_first = !last_number_.has_value();
  const bool is_gap = !is_first && number != *last_number_ + 1;
  last_number_ = number;
  if (is_first) {
    memory_is_live_ = number == 0;  // the camera's first frame: the stages have no state yet
  } else if (is_gap) {
    memory_is_live_ = false;
  }
  if (!recorded.memory.empty() && (!other_ ? !memory_is_live_ : is_first)) {
    const std::vector<std::string> failed = setup_.pipeline->restore(recorded.memory);
    memory_is_live_ = failed.empty();
    if (!failed.empty() && !other_)
      doubt("memory", fmt::format("the saved state of stage '{}' before frame {} is from another version",
                                  failed.front(), number));
    return;
  }
  if (is_first && !memory_is_live_)
    doubt("begin", fmt::format("the clip lacks the stages' state before frame {}", number));
  if (is_gap) doubt("gap", fmt::format("frames are missing before frame {}", number));
}

void ClipReplay::doubt(const char* kind, const std::string& text) {
  if (std::ranges::find(kinds_, kind) != kinds_.end()) return;
  kinds_.push_back(kind);
  doubts_.push_back(text);
}

}  // namespace sslv
