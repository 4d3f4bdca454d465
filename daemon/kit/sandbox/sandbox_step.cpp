// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/sandbox_step.h"

#include "base/clock.h"
#include "base/futex.h"
#include "base/plain_text.h"
#include "kit/sandbox/validate_parts.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>

namespace sslv::sandbox {
namespace {

/// A shared memory file is dropped after this many requests without an image from it.
constexpr std::uint32_t kKeepsFileFor = 256;

/// The memory of an image: it begins at offset `begin` from `data`. The offset is negative if the low bits
/// are stored before `data`.
struct ImageExtent {
  std::ptrdiff_t begin;
  std::size_t bytes;
};
ImageExtent extent_of(const ImageView& image) {
  const std::ptrdiff_t rows = image.stride_bytes * (image.height - 1);
  const std::ptrdiff_t end = rows + static_cast<std::ptrdiff_t>(image.width) * bytes_per_pixel(image.format);
  const std::ptrdiff_t begin = std::min<std::ptrdiff_t>(0, image.to_low_bits);
  return {begin, static_cast<std::size_t>(end + std::max<std::ptrdiff_t>(0, image.to_low_bits) - begin)};
}

template <class Floor>
void swap_parts(typename Floor::Frame& a, typename Floor::Frame& b, PartSet parts) {
  std::size_t i = 0;
  const auto swap_one = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const bool is_one = parts[i++];
    if constexpr (kIsEncodable<T>) {
      if (is_one) std::swap(a.*part.member, b.*part.member);
    }
  };
  std::apply([&](const auto&... part) { (swap_one(part), ...); }, Floor::kParts);
}

template <class Floor>
bool are_sound(const typename Floor::Frame& now, PartSet parts) {
  std::size_t i = 0;
  const auto is_good = [&]<class T>(const Part<typename Floor::Frame, T>& part) {
    const bool is_one = parts[i++];
    if constexpr (kIsEncodable<T>) {
      return !is_one || is_valid(now.*part.member, now);
    } else {
      return true;
    }
  };
  return std::apply([&](const auto&... part) { return (is_good(part) && ...); }, Floor::kParts);
}

}  // namespace

// ---- SandboxReport

void SandboxReport::add(Outcome outcome) {
  --counts_[static_cast<std::size_t>(last_[next_])];
  ++counts_[static_cast<std::size_t>(outcome)];
  last_[next_] = outcome;
  next_ = (next_ + 1) % kImages;
}

void SandboxReport::set_own_note(StageNotes::Kind kind, std::span<const char> text) {
  if (kind == note_kind_ && std::ranges::equal(text, std::span(note_).first(note_length_))) return;
  note_kind_ = kind;
  note_length_ = std::min(text.size(), note_.size());
  std::copy_n(text.begin(), note_length_, note_.begin());
  ++note_number_;
}

void SandboxReport::tell(const StageProcess& process, double deadline_ms, StageNotes& notes) {
  const auto count = [this](Outcome outcome) { return counts_[static_cast<std::size_t>(outcome)]; };
  // load() could spin while the supervisor's thread, possibly of lower priority, is preempted during its
  // write. If try_load() fails, the next call reports the losses.
  if (const auto newest = process.losses.try_load()) losses_ = *newest;
  const Told now{counts_, losses_.count, note_number_};
  if (now == told_) return;
  told_ = now;

  std::array<char, StageNotes::kMaxText> text;
  const auto warn = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    const std::string_view own(note_.data(), note_length_);
    const auto written = fmt::format_to_n(text.data(), text.size(), format, std::forward<Args>(args)...);
    std::size_t size = std::min(written.size, text.size());
    // A single late image must not hide the stage's own note.
    if (note_kind_ != StageNotes::Kind::kNone)
      size += fmt::format_to_n(text.data() + size, text.size() - size, "; it says: {}", own).size;
    notes.warn({text.data(), std::min(size, text.size())});
  };
  if (count(Outcome::kNoProcess) > 0) {
    if (losses_.count == 0) {
      warn("its process is not running");
    } else {
      warn("its process {}; restarted {} {}", std::string_view(losses_.text.data(), losses_.length),
           losses_.count, losses_.count == 1 ? "time" : "times");
    }
  } else if (count(Outcome::kBad) > 0) {
    warn("gave invalid results for {} of the last {} images, which were processed without them",
         count(Outcome::kBad), kImages);
  } else if (count(Outcome::kNoRoom) > 0) {
    warn("was skipped for {} of the last {} images: no space for the parts that it reads",
         count(Outcome::kNoRoom), kImages);
  } else if (count(Outcome::kLate) > 0) {
    warn("took longer than {} ms for {} of the last {} images, which were processed without its results",
         deadline_ms, count(Outcome::kLate), kImages);
  } else if (note_kind_ == StageNotes::Kind::kWarning) {
    notes.warn({note_.data(), note_length_});
  } else if (note_kind_ == StageNotes::Kind::kNote) {
    notes.say({note_.data(), note_length_});
  } else {
    notes.clear();
  }
}

// ---- SandboxStep

template <class Floor>
SandboxStep<Floor>::SandboxStep(const StageNeeds& needs, std::vector<SandboxOwnPart> own_parts,
                                std::shared_ptr<StageProcess> process, std::chrono::milliseconds min_deadline)
    : needs_(needs),
      own_parts_(std::move(own_parts)),
      process_(std::move(process)),
      min_deadline_(min_deadline),
      compared_(std::make_unique_for_overwrite<std::byte[]>(kMiB)) {}

template <class Floor>
SandboxStep<Floor>::~SandboxStep() {
  process_->is_wanted.store(false);
}

template <class Floor>
void SandboxStep<Floor>::run(const typename Floor::Inputs& in, const void* params) noexcept {
  const auto& given = *static_cast<const SandboxParams*>(params);
  Outcome outcome = Outcome::kNoRoom;
  try {
    outcome = ask(in, given);
  } catch (const std::exception&) {  // out of memory for the answer
  }
  if (outcome == Outcome::kDone) {
    process_->failures_in_a_row.store(0, std::memory_order_relaxed);
  } else {
    // kNoRoom and kNoProcess are not the stage's fault and do not count as failures.
    if (outcome == Outcome::kBad || outcome == Outcome::kLate)
      process_->failures_in_a_row.fetch_add(1, std::memory_order_relaxed);
    make_empty(in.frame, needs_.writes);
    for (const SandboxOwnPart& own : own_parts_) {
      if (own.is_written) in.frame.own_parts.code_at(*own.place).clear(in.frame.own_parts.at(*own.place));
    }
  }
  report_.add(outcome);
  report_.tell(*process_, given.own.deadline_ms, this->notes);
}

template <class Floor>
SandboxReport::Outcome SandboxStep<Floor>::ask(const typename Floor::Inputs& in,
                                               const SandboxParams& params) {
  const std::uint32_t generation = process_->generation.load();
  if (generation != generation_) report_.set_own_note(StageNotes::Kind::kNone, {});
  if (generation == 0) return Outcome::kNoProcess;
  ToStage& to = process_->channel.to();
  FromStage& from = process_->channel.from();
  if (generation != generation_) {  // a new process lacks the files, but reads the constants
    generation_ = generation;
    is_busy_ = false;
    sent_files_ = {};
    tell_priority();
  }
  if (is_busy_) {
    if (from.answer.load(std::memory_order_acquire) != request_) return Outcome::kLate;
    if (from.kind == AnswerKind::kDone) take_note();  // a late result is useless, but its note is still valid
    is_busy_ = false;
  }
  if (!write_request(in, params)) return Outcome::kNoRoom;

  const auto deadline = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double, std::milli>(params.own.deadline_ms));
  const auto until = std::chrono::steady_clock::now() + std::max(deadline, min_deadline_);
  process_->asked_ns.store(steady_ns());
  to.request.store(++request_);
  is_busy_ = true;
  if (from.is_asleep.load() != 0) futex_wake_all(to.request, FutexScope::kShared);
  if (!wait_for(request_, generation, until))
    return process_->generation.load() == generation ? Outcome::kLate : Outcome::kNoProcess;
  is_busy_ = false;
  if (from.kind != AnswerKind::kDone || !take_answer(in.frame)) return Outcome::kBad;
  take_note();
  return Outcome::kDone;
}

template <class Floor>
bool SandboxStep<Floor>::wait_for(std::uint32_t request, std::uint32_t generation,
                                  std::chrono::steady_clock::time_point until) const {
  using Clock = std::chrono::steady_clock;
  ToStage& to = process_->channel.to();
  const FromStage& from = process_->channel.from();
  to.is_waiting.store(1);
  bool is_answered = false;
  for (;;) {
    const std::uint32_t answer = from.answer.load();
    is_answered = answer == request;
    if (is_answered || process_->generation.load() != generation || Clock::now() >= until) break;
    futex_wait(from.answer, answer, until, FutexScope::kShared);
  }
  to.is_waiting.store(0);
  return is_answered;
}

/// Gives the process the priority of the thread that waits for it.
template <class Floor>
void SandboxStep<Floor>::tell_priority() {
  ToStage& to = process_->channel.to();
  sched_param parameters{};
  int policy = SCHED_OTHER;
  if (::pthread_getschedparam(::pthread_self(), &policy, &parameters) != 0) return;
  to.policy = policy;
  to.priority = parameters.sched_priority;
  to.nice = ::getpriority(PRIO_PROCESS, 0);  // nice value of this thread
}

// ---- writing

template <class Floor>
template <class T>
bool SandboxStep<Floor>::write_if_changed(Constant which, const T& value) {
  ByteWriter writer({compared_.get(), kMiB});
  encode(value, writer);
  if (!writer.fits()) return false;
  ToStage::Sent& sent = process_->channel.to().constants[static_cast<std::size_t>(which)];
  std::byte* const there = process_->channel.constant(which).data();
  if (sent.version != 0 && sent.bytes == writer.written() &&
      std::memcmp(there, compared_.get(), writer.written()) == 0)
    return true;
  std::memcpy(there, compared_.get(), writer.written());
  sent.bytes = writer.written();
  ++sent.version;
  return true;
}

template <class Floor>
template <class T>
bool SandboxStep<Floor>::write_by_id(Constant which, std::uint64_t id, const T& value) {
  std::uint64_t& sent_id = sent_ids_[static_cast<std::size_t>(which)];
  if (sent_id == id) return true;
  sent_id = 0;
  ByteWriter writer(process_->channel.constant(which));
  encode(value, writer);
  if (!writer.fits()) return false;
  sent_id = id;
  ToStage::Sent& sent = process_->channel.to().constants[static_cast<std::size_t>(which)];
  sent.bytes = writer.written();
  ++sent.version;
  return true;
}

template <>
bool SandboxStep<CameraFloor>::write_given(const CameraFloor::Inputs& in, ByteWriter&) {
  const auto is_taken = [&]<class T>(std::type_identity<T>) { return takes<CameraFloor, T>(needs_); };
  const CameraContext& context = in.context;
  return (!is_taken(std::type_identity<const Scene&>{}) ||
          write_if_changed(Constant::kScene, *context.scene)) &&
         (!is_taken(std::type_identity<const Lut&>{}) ||
          write_by_id(Constant::kLut, context.adapted_lut->id(), *context.adapted_lut)) &&
         (!is_taken(std::type_identity<const Mask&>{}) ||
          write_by_id(Constant::kMask, context.looked_at().id(), context.looked_at())) &&
         (!is_taken(std::type_identity<const PatternTable&>{}) ||
          write_if_changed(Constant::kPatterns, *context.patterns));
}

template <>
bool SandboxStep<FieldFloor>::write_given(const FieldFloor::Inputs& in, ByteWriter& writer) {
  process_->channel.to().now_s = takes<FieldFloor, const FieldClock&>(needs_) ? in.clock.now_s() : 0;
  if (takes<FieldFloor, const FieldSize&>(needs_)) encode(in.field, writer);
  if (takes<FieldFloor, const BallModel&>(needs_)) encode(in.ball, writer);
  return true;
}

template <class Floor>
bool SandboxStep<Floor>::write_request(const typename Floor::Inputs& in, const SandboxParams& params) {
  ToStage& to = process_->channel.to();
  if (!write_by_id(Constant::kParams, params.id, params.json)) return false;
  ByteWriter writer(process_->channel.parts_to_stage());
  if (!write_given(in, writer)) return false;
  encode_parts<Floor>(in.frame, needs_.sent(), writer);
  for (const SandboxOwnPart& own : own_parts_) {
    if (own.is_written) continue;
    const OwnPartCode& code = in.frame.own_parts.code_at(*own.place);
    if (code.encode == nullptr) return false;
    writer.whole([&] { code.encode(in.frame.own_parts.at(*own.place), writer); });
  }
  if (!writer.fits()) return false;
  to.parts_bytes = writer.written();
  if constexpr (std::is_same_v<Floor, CameraFloor>) {
    to.image_at = ImageAt::kNowhere;
    constexpr std::size_t kImage = part_index<CameraFloor, Image>();
    // The size is sent even without the image, because the stage's results must fit the size.
    if (needs_.reads[kImage] && !in.frame.image.view().empty()) {
      write_image(in.frame.image.view());
      return to.image_at != ImageAt::kNowhere;
    }
  }
  return true;
}

template <class Floor>
void SandboxStep<Floor>::write_image(const ImageView& image) {
  ToStage& to = process_->channel.to();
  to.image = image;
  to.image.data = nullptr;
  const ImageExtent extent = extent_of(image);
  if (request_ % kKeepsFileFor == 0) forget_files();
  if (image.stride_bytes > 0) {
    if (const auto place = shared_place(image.data + extent.begin, extent.bytes);
        place && sends_file(*place)) {
      to.image_at = ImageAt::kShared;
      to.image_id = place->id;
      to.image_offset = place->offset + static_cast<std::size_t>(-extent.begin);
      return;
    }
  }
  // The image is not in shared memory: copy it row by row, without the padding of its rows.
  const auto row_bytes =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(bytes_per_pixel(image.format));
  const std::size_t plane = row_bytes * static_cast<std::size_t>(image.height);
  const bool has_low_bits = image.to_low_bits != 0;
  const std::span<std::byte> room = process_->channel.image();
  if (plane * (has_low_bits ? 2 : 1) > room.size()) return;
  for (int y = 0; y < image.height; ++y) {
    std::byte* const row = room.data() + row_bytes * static_cast<std::size_t>(y);
    std::memcpy(row, image.row(y), row_bytes);
    if (has_low_bits) std::memcpy(row + plane, image.row(y) + image.to_low_bits, row_bytes);
  }
  to.image.stride_bytes = static_cast<std::ptrdiff_t>(row_bytes);
  to.image.to_low_bits = has_low_bits ? static_cast<std::ptrdiff_t>(plane) : 0;
  to.image_at = ImageAt::kCopied;
  to.image_offset = 0;
}

/// Whether the process has this shared memory file; sends the file if necessary.
template <class Floor>
bool SandboxStep<Floor>::sends_file(const SharedPlace& place) {
  for (SentFile& sent : sent_files_) {
    if (sent.id != place.id) continue;
    sent.used = request_;
    return true;
  }
  ImageFile message{.id = place.id, .bytes = place.memory_bytes};
  SentFile* oldest = &sent_files_[0];
  for (SentFile& sent : sent_files_) {
    if (oldest->id != 0 && (sent.id == 0 || request_ - sent.used > request_ - oldest->used)) oldest = &sent;
  }
  *oldest = {};
  for (std::size_t i = 0; i < kMaxKept; ++i) message.keep[i] = sent_files_[i].id;
  if (!send_file(message, place.file)) return false;
  *oldest = {place.id, request_};
  return true;
}

template <class Floor>
void SandboxStep<Floor>::forget_files() {
  auto kept = sent_files_;
  for (SentFile& sent : kept) {
    if (sent.id != 0 && request_ - sent.used > kKeepsFileFor) sent = {};
  }
  ImageFile message;
  bool has_changed = false;
  for (std::size_t i = 0; i < kMaxKept; ++i) {
    message.keep[i] = kept[i].id;
    has_changed = has_changed || kept[i].id != sent_files_[i].id;
  }
  if (has_changed && send_file(message, -1)) sent_files_ = kept;
}

/// Never waits: if the socket is full, the file is sent with a later image.
template <class Floor>
bool SandboxStep<Floor>::send_file(const ImageFile& message, int file) {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  ImageFile copy = message;
  iovec part{&copy, sizeof copy};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  if (file >= 0) {
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* const with = CMSG_FIRSTHDR(&header);
    with->cmsg_level = SOL_SOCKET;
    with->cmsg_type = SCM_RIGHTS;
    with->cmsg_len = CMSG_LEN(sizeof file);
    std::memcpy(CMSG_DATA(with), &file, sizeof file);
  }
  if (::sendmsg(process_->control.ours.fd(), &header, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) return false;
  ++process_->channel.to().files;
  return true;
}

// ---- reading

template <class Floor>
bool SandboxStep<Floor>::take_answer(typename Floor::Frame& frame) {
  std::span<const std::byte> bytes = process_->channel.parts_from_stage();
  const std::uint64_t count = process_->channel.from().parts_bytes;
  if (count > bytes.size()) return false;
  bytes = bytes.first(count);
  if (!decode_limited_parts<Floor>(bytes, scratch_, needs_.answered())) return false;
  swap_parts<Floor>(frame, scratch_, needs_.answered());
  if (are_sound<Floor>(frame, needs_.answered()) && take_own_parts(frame, bytes)) return true;
  swap_parts<Floor>(frame, scratch_, needs_.answered());
  return false;
}

/// Decodes all own parts into scratch first: if one is invalid, the frame's parts stay unchanged.
template <class Floor>
bool SandboxStep<Floor>::take_own_parts(typename Floor::Frame& frame, std::span<const std::byte> from) {
  const auto is_answered = [](const SandboxOwnPart& own) { return own.is_written || own.is_updated; };
  own_scratch_.resize(own_parts_.size());
  ByteReader reader(from, true);
  for (std::size_t i = 0; i < own_parts_.size(); ++i) {
    if (!is_answered(own_parts_[i])) continue;
    auto part = reader.whole();
    const OwnPartCode& code = frame.own_parts.code_at(*own_parts_[i].place);
    if (!part || part->left() > kMaxOwnPartBytes || code.decode == nullptr) return false;
    OwnScratch& scratch = own_scratch_[i];
    scratch.bytes.resize(part->left());
    if (!part->bytes(scratch.bytes.data(), scratch.bytes.size())) return false;
    if (code.is_flat) continue;  // any bytes are valid
    if (scratch.part == nullptr || scratch.code.create != code.create) {
      scratch.part = code.create();
      scratch.code = code;
    }
    ByteReader copy(scratch.bytes, true);
    if (!code.decode(copy, scratch.part.get())) return false;
  }
  if (reader.left() != 0) return false;
  bool is_good = true;
  for (std::size_t i = 0; i < own_parts_.size(); ++i) {
    if (!is_answered(own_parts_[i])) continue;
    ByteReader copy(own_scratch_[i].bytes, true);
    const std::size_t place = *own_parts_[i].place;
    is_good = frame.own_parts.code_at(place).decode(copy, frame.own_parts.at(place)) && is_good;
  }
  return is_good;
}

template <class Floor>
void SandboxStep<Floor>::take_note() {
  const FromStage& from = process_->channel.from();
  const StageNotes::Kind kind = from.note_kind;
  std::array<char, StageNotes::kMaxText> text = from.note;
  const std::size_t length = std::min<std::size_t>(from.note_length, text.size());
  if (kind != StageNotes::Kind::kNote && kind != StageNotes::Kind::kWarning) {
    report_.set_own_note(StageNotes::Kind::kNone, {});
    return;
  }
  // The note is shown in panels and logs, where control characters and invalid UTF-8 do harm.
  const bool is_plain = is_plain_text({text.data(), length});
  for (std::size_t i = 0; i < length && !is_plain; ++i) {
    if (text[i] < ' ' || text[i] > '~') text[i] = '?';
  }
  report_.set_own_note(kind, {text.data(), length});
}

template class SandboxStep<CameraFloor>;
template class SandboxStep<FieldFloor>;

}  // namespace sslv::sandbox
