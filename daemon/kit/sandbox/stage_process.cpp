// SPDX-License-Identifier: Apache-2.0
// Runs in a library's process: describes the library's stages, validates their parameters, or runs one of
// them.
#include "kit/sandbox/stage_process.h"

#include "base/futex.h"
#include "base/json.h"
#include "kit/load_stages.h"
#include "kit/read_stamp.h"
#include "kit/sandbox/channel.h"
#include "kit/sandbox/frame_codec.h"
#include "kit/sandbox/start_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sslv {
namespace {

using namespace sandbox;

/// Loads the current file, which may not be the file that was described to the service. Throws
/// StageLibraryError.
StageRows load_checked(const std::string& library) {
  check_stamp(read_stamp(library));
  return load_rows(library);
}

/// Makes this process end with the service, drops the right to gain privileges, and makes this process the
/// first that the kernel kills when memory is short. False if the service has already ended.
bool settle_in(pid_t service) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != service) return false;  // the service ended before prctl()
  // Unblock all signals: this process runs the same program as the service, which blocks its signals before
  // main() starts.
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  std::signal(SIGPIPE, SIG_IGN);
  if (std::FILE* file = std::fopen("/proc/self/oom_score_adj", "we")) {
    std::fputs("500", file);
    std::fclose(file);
  }
  const rlimit no_core{};
  ::setrlimit(RLIMIT_CORE, &no_core);  // crashes are expected here: skip the slow core dump
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  return true;
}

template <class Floor>
const BasicStageType<Floor>& find_row(const std::vector<BasicStageType<Floor>>& rows,
                                      const std::string& name) {
  const auto found = std::ranges::find_if(rows, [&](const auto& row) { return row.name == name; });
  if (found == rows.end()) throw std::runtime_error("the library has no stage '" + name + "' any more");
  return *found;
}

// ---- describing, and parameters

template <class Floor>
Json describe_rows(const std::vector<BasicStageType<Floor>>& rows) {
  Json all = Json::array();
  for (const auto& row : rows) {
    check_row(row);
    const StageNeeds needs = needs_of(row);
    Json own_parts = Json::array();
    for (const OwnPartUse& use : row.own_parts) {
      own_parts.push_back({{"name", use.type.name},
                           {"layout", use.type.layout},
                           {"is_written", use.is_written},
                           {"is_updated", use.is_updated},
                           {"is_encodable", use.type.code.encode != nullptr}});
    }
    all.push_back({{"name", row.name},
                   {"help", row.help},
                   {"reads", needs.reads.to_ullong()},
                   {"writes", needs.writes.to_ullong()},
                   {"updates", needs.updates.to_ullong()},
                   {"takes", needs.takes.to_ulong()},
                   {"own_parts", std::move(own_parts)},
                   {"schema", row.schema()},
                   {"defaults", row.parse(Json::object(), "").complete}});
  }
  return all;
}

template <class Floor>
Json parsed_params(const std::vector<BasicStageType<Floor>>& rows, const Json& request) {
  return {{"complete", find_row(rows, request.at("stage").get<std::string>())
                           .parse(request.at("json"), request.at("path").get<std::string>())
                           .complete}};
}

Json answer_to(const Json& request, const StageRows& rows) {
  if (request.at("ask") == "describe")
    return {{"camera", describe_rows(rows.camera)}, {"field", describe_rows(rows.field)}};
  if (request.at("floor") == kFloorName<CameraFloor>) return parsed_params(rows.camera, request);
  return parsed_params(rows.field, request);
}

int answer_question(const std::string& library) {
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t count = 0; (count = ::read(kControlFile, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(count));
  Json answer;
  try {
    answer = answer_to(parse_own_json(text), load_checked(library));
  } catch (const std::exception& error) {
    answer = {{"error", error.what()}};
  }
  // The newline marks the end of the answer: other processes may still hold the socket open.
  const std::string out = json_text(answer) + '\n';
  for (std::size_t done = 0; done < out.size();) {
    const ssize_t count = ::write(kControlFile, out.data() + done, out.size() - done);
    if (count <= 0) return EXIT_FAILURE;
    done += static_cast<std::size_t>(count);
  }
  return EXIT_SUCCESS;
}

// ---- running

/// Maps the service's image memory, each file once.
class ImageFiles {
 public:
  ~ImageFiles() {
    for (const Mapped& one : mapped_) ::munmap(one.begin, one.bytes);
  }

  /// Receives the pending messages if `sent` has changed.
  void take(std::uint32_t sent) {
    if (std::exchange(sent_, sent) == sent) return;
    for (;;) {
      ImageFile message;
      alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control;
      iovec part{&message, sizeof message};
      msghdr header{};
      header.msg_iov = &part;
      header.msg_iovlen = 1;
      header.msg_control = control.data();
      header.msg_controllen = control.size();
      if (::recvmsg(kControlFile, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC) != sizeof message) return;
      std::erase_if(mapped_, [&](const Mapped& one) {
        if (one.id != message.id && std::ranges::count(message.keep, one.id) > 0) return false;
        ::munmap(one.begin, one.bytes);
        return true;
      });
      const cmsghdr* const with = CMSG_FIRSTHDR(&header);
      if (with == nullptr || with->cmsg_type != SCM_RIGHTS) continue;
      int file = -1;
      std::memcpy(&file, CMSG_DATA(with), sizeof file);
      void* const place = ::mmap(nullptr, message.bytes, PROT_READ, MAP_SHARED, file, 0);
      ::close(file);
      if (place != MAP_FAILED) mapped_.push_back({message.id, place, message.bytes});
    }
  }
  const std::uint8_t* find(std::uint64_t id) const {
    for (const Mapped& one : mapped_) {
      if (one.id == id) return static_cast<const std::uint8_t*>(one.begin);
    }
    return nullptr;
  }

 private:
  struct Mapped {
    std::uint64_t id;
    void* begin;
    std::size_t bytes;
  };
  std::vector<Mapped> mapped_;
  std::uint32_t sent_ = 0;
};

/// Constants in the service's memory, decoded again when they have changed.
class Constants {
 public:
  explicit Constants(const Channel& channel) : channel_(channel) {}

  /// False if the constant cannot be decoded. Sets `changed` to whether it was decoded again.
  template <class T>
  bool take(Constant which, T& value, bool& changed) {
    const auto i = static_cast<std::size_t>(which);
    const ToStage::Sent sent = channel_.to().constants[i];
    changed = sent.version != versions_[i];
    if (!changed) return true;
    ByteReader reader(channel_.constant(which).first(std::min(sent.bytes, kConstantRoom[i])));
    if (!decode(reader, value)) return false;
    versions_[i] = sent.version;
    return true;
  }
  template <class T>
  bool take(Constant which, T& value) {
    bool changed = false;
    return take(which, value, changed);
  }

 private:
  const Channel& channel_;
  std::array<std::uint32_t, kConstants> versions_{};
};

struct NoDetectionSink final : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};
struct NoFieldSink final : FieldSink {
  void publish(const TrackedField&) noexcept override {}
};
/// The service's clock at the time of the request.
struct SentClock final : FieldClock {
  double now_s() const noexcept override { return time_s; }
  double time_s = 0;
};

/// The arguments of a camera's stage besides the frame.
class CameraGiven {
 public:
  CameraGiven() {
    context_.scene = scene_;
    context_.adapted_lut = lut_;
    context_.mask = mask_;
    context_.patterns = patterns_;
  }
  bool take(const StageNeeds& needs, Constants& constants, const ToStage&, ByteReader&) {
    return (!takes<CameraFloor, const Scene&>(needs) || constants.take(Constant::kScene, *scene_)) &&
           (!takes<CameraFloor, const Lut&>(needs) || constants.take(Constant::kLut, *lut_)) &&
           (!takes<CameraFloor, const Mask&>(needs) || constants.take(Constant::kMask, *mask_)) &&
           (!takes<CameraFloor, const PatternTable&>(needs) ||
            constants.take(Constant::kPatterns, *patterns_));
  }
  CameraFloor::Inputs inputs(Frame& frame) { return {frame, context_, sink_}; }

 private:
  std::shared_ptr<Scene> scene_ = std::make_shared<Scene>();
  std::shared_ptr<Lut> lut_ = std::make_shared<Lut>();
  std::shared_ptr<Mask> mask_ = std::make_shared<Mask>();
  std::shared_ptr<PatternTable> patterns_ = std::make_shared<PatternTable>();
  CameraContext context_;
  NoDetectionSink sink_;
};

/// The arguments of a field stage besides the frame.
class FieldGiven {
 public:
  bool take(const StageNeeds& needs, Constants&, const ToStage& to, ByteReader& reader) {
    clock_.time_s = to.now_s;
    return (!takes<FieldFloor, const FieldSize&>(needs) || decode(reader, field_)) &&
           (!takes<FieldFloor, const BallModel&>(needs) || decode(reader, ball_));
  }
  FieldFloor::Inputs inputs(FieldFrame& frame) { return {frame, field_, ball_, clock_, sink_}; }

 private:
  FieldSize field_;
  BallModel ball_;
  SentClock clock_;
  NoFieldSink sink_;
};

template <class Floor>
class StageRunner {
 public:
  StageRunner(const BasicStageType<Floor>& row, const Channel& channel)
      : row_(row), needs_(needs_of(row)), channel_(channel), constants_(channel) {
    // Numbers the library's own parts that the stage uses (OwnPartUse). The numbers are their indices in this
    // process's frame.
    std::size_t places = 0;
    std::set<std::size_t*> placed;
    for (const OwnPartUse& use : row.own_parts) {
      if (placed.insert(use.place).second) *use.place = places++;
    }
    for (const OwnPartUse& use : row.own_parts) frame_.own_parts.prepare(*use.place, use.type);
    step_ = row.create();
  }

  /// Answers requests forever.
  [[noreturn]] void run() {
    const ToStage& to = channel_.to();
    FromStage& from = channel_.from();
    std::uint32_t request = to.request.load();
    if (::send(kControlFile, "+", 1, 0) != 1) std::_Exit(EXIT_FAILURE);
    for (;;) {
      request = next_request(request);
      apply_priority();
      from.kind = answer();
      from.answer.store(request);
      if (to.is_waiting.load() != 0) futex_wake_all(from.answer, FutexScope::kShared);
    }
  }

 private:
  std::uint32_t next_request(std::uint32_t last) const {
    const ToStage& to = channel_.to();
    FromStage& from = channel_.from();
    using Clock = std::chrono::steady_clock;
    for (;;) {
      from.is_asleep.store(1);
      if (to.request.load() == last)
        futex_wait(to.request, last, Clock::now() + std::chrono::seconds(1), FutexScope::kShared);
      from.is_asleep.store(0);
      if (const std::uint32_t now = to.request.load(); now != last) return now;
    }
  }

  void apply_priority() {
    const ToStage& to = channel_.to();
    const std::array<int, 3> wanted{to.policy, to.priority, to.nice};
    if (wanted == priority_) return;
    priority_ = wanted;
    sched_param parameters{};
    // One priority lower where possible, because a hanging stage must not block the thread that waits for it.
    parameters.sched_priority = std::max(to.priority - 1, std::min(to.priority, 1));
    ::sched_setscheduler(0, to.policy, &parameters);  // as far as permitted
    ::setpriority(PRIO_PROCESS, 0, to.nice);
  }

  AnswerKind answer() {
    const ToStage& to = channel_.to();
    files_.take(to.files);
    if (!take_image()) return AnswerKind::kUnreadable;
    std::string params_text;
    bool changed = false;
    if (!constants_.take(Constant::kParams, params_text, changed)) return AnswerKind::kUnreadable;
    if (changed || params_ == nullptr) {
      params_ = nullptr;
      try {
        params_ = row_.parse(parse_own_json(params_text), "").params;
      } catch (const std::exception& error) {
        std::fprintf(stderr, "its parameters: %s\n", error.what());
        return AnswerKind::kUnreadable;
      }
    }
    ByteReader reader(channel_.parts_to_stage().first(std::min(to.parts_bytes, kPartsRoom)));
    if (!given_.take(needs_, constants_, to, reader) || !decode_parts<Floor>(reader, frame_, needs_.sent()))
      return AnswerKind::kUnreadable;
    for (const OwnPartUse& use : row_.own_parts) {
      const OwnPartCode& code = frame_.own_parts.code_at(*use.place);
      code.clear(frame_.own_parts.at(*use.place));
      if (!use.is_written && !take_own(reader, use)) return AnswerKind::kUnreadable;
    }

    step_->run(given_.inputs(frame_), params_.get());

    ByteWriter writer(channel_.parts_from_stage());
    // The service would refuse longer lists.
    if (!encode_parts<Floor>(frame_, needs_.answered(), writer, true)) return AnswerKind::kNoRoom;
    for (const OwnPartUse& use : row_.own_parts) {
      if ((use.is_written || use.is_updated) && !give_own(use, writer)) return AnswerKind::kNoRoom;
    }
    channel_.from().parts_bytes = writer.written();
    give_note();
    return writer.fits() ? AnswerKind::kDone : AnswerKind::kNoRoom;
  }

  bool take_image() {
    if constexpr (std::is_same_v<Floor, CameraFloor>) {
      const ToStage& to = channel_.to();
      ImageView view = to.image;
      if (to.image_at == ImageAt::kNowhere) view = {};
      if (to.image_at == ImageAt::kCopied)
        view.data = reinterpret_cast<const std::uint8_t*>(channel_.image().data()) + to.image_offset;
      if (to.image_at == ImageAt::kShared) {
        const std::uint8_t* const memory = files_.find(to.image_id);
        if (memory == nullptr) return false;
        view.data = memory + to.image_offset;
      }
      frame_.image = Image(view, nullptr, nullptr, nullptr);
    }
    return true;
  }

  /// The service handles own parts as plain bytes. A part without bytes was not created for this frame.
  bool take_own(ByteReader& reader, const OwnPartUse& use) {
    std::optional<ByteReader> own = reader.whole();
    if (!own) return false;
    return own->left() == 0 ||
           frame_.own_parts.code_at(*use.place).decode(*own, frame_.own_parts.at(*use.place));
  }
  bool give_own(const OwnPartUse& use, ByteWriter& writer) {
    const std::size_t before = writer.written();
    writer.whole(
        [&] { frame_.own_parts.code_at(*use.place).encode(frame_.own_parts.at(*use.place), writer); });
    return writer.written() - before <= kMaxOwnPartBytes;
  }

  void give_note() {
    FromStage& from = channel_.from();
    const StageNotes::Note note = step_->notes.read();
    from.note_kind = note.kind;
    from.note_length = static_cast<std::uint8_t>(std::min(note.text.size(), from.note.size()));
    std::memcpy(from.note.data(), note.text.data(), from.note_length);
  }

  const BasicStageType<Floor>& row_;
  const StageNeeds needs_;
  const Channel& channel_;
  Constants constants_;
  ImageFiles files_;
  std::conditional_t<std::is_same_v<Floor, CameraFloor>, CameraGiven, FieldGiven> given_;
  typename Floor::Frame frame_;
  std::unique_ptr<Step<Floor>> step_;
  StageParams params_;
  std::array<int, 3> priority_{SCHED_OTHER, 0, 0};
};

template <class Floor>
[[noreturn]] void run_row(const std::vector<BasicStageType<Floor>>& rows, const std::string& stage,
                          const std::string& contract) {
  const BasicStageType<Floor>& row = find_row(rows, stage);
  if (contract_of(row) != contract) {
    throw std::runtime_error("its library was replaced and has other parts now: restart the service");
  }
  const Channel channel(kToStageFile, kFromStageFile);
  StageRunner<Floor>(row, channel).run();
}

int run_stage(const std::string& library, const std::string& floor, const std::string& stage,
              const std::string& contract) {
  try {
    const StageRows rows = load_checked(library);
    if (floor == kFloorName<CameraFloor>) run_row(rows.camera, stage, contract);
    run_row(rows.field, stage, contract);
  } catch (const std::exception& error) {
    const std::string word = std::string("-") + error.what();
    (void)!::send(kControlFile, word.data(), std::min<std::size_t>(word.size(), 900), 0);
    ::pause();  // until the service has read the message and kills this process
    return EXIT_FAILURE;
  }
}

}  // namespace

std::optional<int> stage_process_main(int argc, char** argv) {
  const std::span words(argv, static_cast<std::size_t>(argc));
  if (words.size() < 2 || words[1] != kStageProcessFlag) return std::nullopt;
  const auto word = [&](std::size_t i) { return i < words.size() ? std::string(words[i]) : std::string(); };
  if (!settle_in(static_cast<pid_t>(std::atoi(word(2).c_str())))) return EXIT_FAILURE;
  if (word(3) == "ask") return answer_question(word(4));
  if (word(3) == "run") return run_stage(word(4), word(5), word(6), word(7));
  return EXIT_FAILURE;
}

}  // namespace sslv
