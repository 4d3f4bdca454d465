// SPDX-License-Identifier: Apache-2.0
#include "clips/clip_reader.h"

#include "base/plain_text.h"
#include "clips/clip_format.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

namespace sslv {
namespace {

constexpr std::size_t kHeadsBytes = kClipBlockBytes + kClipFrameBytes;
/// Mask for Entry::place; no file is larger.
constexpr std::uint64_t kMaxPlace = (std::uint64_t{1} << 62U) - 1;

std::string text_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? escaped_text(found->get<std::string>()) : std::string();
}

double number_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0;
}

/// ClipAbout::why of crash clips from before ClipAbout::kind existed; other clips could not have this text.
constexpr std::string_view kWhyOfOldCrashClips = "the service crashed";

/// The parsed JSON; null if the text is not valid JSON or too large.
Json json_in(std::span<const std::byte> text) {
  try {
    return parse_bounded_json({reinterpret_cast<const char*>(text.data()), text.size()});
  } catch (const Json::exception&) {
  } catch (const std::length_error&) {
  }
  return nullptr;
}

}  // namespace

struct ClipReader::File {
  using Room = std::function<std::uint8_t*(std::size_t bytes)>;

  File(const std::filesystem::path& path, const std::stop_token& stop)
      : name(path.string()),
        // O_NONBLOCK: otherwise, opening a pipe would wait for a writer.
        fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (fd < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    try {
      open(stop);
    } catch (...) {
      ::close(fd);
      throw;
    }
  }
  ~File() { ::close(fd); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[noreturn]] void refuse(const std::string& why) const {
    throw ClipError(fmt::format("{}: {}", name, why));
  }
  void note(const std::string& what) {
    if (problem.empty()) problem = fmt::format("{}: {}", name, what);
  }

  /// Reads from offset `place` into `first`, then into `second`. Throws ClipError, also at the end of the
  /// file.
  void read_at(std::uint64_t place, std::span<std::byte> first, std::span<std::byte> second = {}) const {
    while (!first.empty() || !second.empty()) {
      const std::array<iovec, 2> parts{{{first.data(), first.size()}, {second.data(), second.size()}}};
      const ssize_t count = ::preadv(fd, parts.data(), 2, static_cast<off_t>(place));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
      if (count == 0) refuse("became shorter while it was read");
      const auto got = static_cast<std::size_t>(count);
      place += got;
      const std::size_t of_first = std::min(got, first.size());
      first = first.subspan(of_first);
      second = second.subspan(got - of_first);
    }
  }

  /// Whether a block lies completely between the head of the file and `end`.
  bool is_inside(std::uint64_t place, std::uint64_t payload_bytes, std::uint64_t end) const {
    return place >= kClipHeadBytes && place <= end && end - place >= kClipBlockBytes &&
           payload_bytes <= end - place - kClipBlockBytes;
  }

  void open(const std::stop_token& stop) {
    struct stat status {};
    if (::fstat(fd, &status) != 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (!S_ISREG(status.st_mode)) refuse("is not a clip: not a regular file");
    size = static_cast<std::uint64_t>(status.st_size);
    check_head();
    if (!read_index()) {
      is_unfinished = true;
      scan(stop);
    }
    put_in_order();
    if (!has_about) note("its metadata is missing or damaged");
    ::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
  }

  void check_head() const {
    std::array<std::byte, kClipHeadBytes> head{};
    const auto there = std::span(head).first(std::min<std::uint64_t>(size, head.size()));
    read_at(0, there);
    const auto known = clip_head();
    if (there.empty()) refuse("is not a clip: it is empty");
    if (std::ranges::equal(there, known)) return;
    constexpr std::size_t kName = kClipMagic.size() - 3;  // without the line ends
    if (!std::ranges::equal(there.first(std::min(there.size(), kName)),
                            std::span(known).first(std::min(there.size(), kName))))
      refuse("is not a clip: it does not start with the clip signature");
    if (there.size() < head.size()) refuse("is not a clip: it ends within its header");
    if (!std::ranges::equal(there.first(kClipMagic.size()), std::span(known).first(kClipMagic.size())))
      refuse("was damaged by a transfer in text mode; transfer it in binary mode");
    refuse(fmt::format("has an unknown clip version {}; expected {}", u32_at(head, kClipMagic.size()),
                       kClipVersion));
  }

  /// False if there is no valid index. Throws ClipError if the index lists too many blocks.
  bool read_index() {
    constexpr std::uint64_t kLeast = kClipHeadBytes + kClipBlockBytes + kClipTrailerBytes;
    if (size < kLeast) return false;
    std::array<std::byte, kClipTrailerBytes> trailer{};
    read_at(size - trailer.size(), trailer);
    const std::uint64_t end = size - trailer.size();
    const auto place = index_place_of(trailer);
    if (!place || !is_inside(*place, 0, end)) return false;
    std::array<std::byte, kClipBlockBytes> bytes{};
    read_at(*place, bytes);
    const auto head = block_head_of(bytes);
    if (!head || head->type != static_cast<std::uint32_t>(ClipBlock::kIndex) ||
        head->bytes % kClipIndexBytes != 0 || !is_inside(*place, head->bytes, end) ||
        *place + clip_block_bytes(head->bytes) != end)
      return false;
    const std::uint64_t lines = head->bytes / kClipIndexBytes;
    if (lines > kMaxClipBlocks)
      refuse(fmt::format("has an index of {} blocks; a clip has at most {}", lines, kMaxClipBlocks));
    bool fits = true;
    std::uint64_t free = kClipHeadBytes;  // end of the previous block
    std::size_t frames = 0;
    const std::uint32_t sum = each_index_line(*place, lines, [&](const ClipIndexLine& line) {
      fits = fits && line.place >= free && line.place % 8 == 0 && is_inside(line.place, line.bytes, *place);
      const bool is_frame = line.type == static_cast<std::uint32_t>(ClipBlock::kFrame);
      fits = fits && (!is_frame || (line.bytes >= kClipFrameBytes && std::isfinite(line.t_capture_s)));
      frames += is_frame;
      if (fits) free = line.place + clip_block_bytes(line.bytes);
    });
    if (sum != head->sum || !fits) return false;
    entries.reserve(frames);
    each_index_line(*place, lines, [&](const ClipIndexLine& line) { take_line(line); });
    return true;
  }

  /// Calls use(line) for each line. Returns the checksum of all lines.
  template <class Use>
  std::uint32_t each_index_line(std::uint64_t index, std::uint64_t lines, const Use& use) const {
    std::vector<std::byte> some(1024 * kClipIndexBytes);
    std::uint32_t sum = 0;
    for (std::uint64_t at = index + kClipBlockBytes; lines > 0;) {
      const std::uint64_t count = std::min<std::uint64_t>(lines, 1024);
      const auto part = std::span(some).first(static_cast<std::size_t>(count) * kClipIndexBytes);
      read_at(at, part);
      sum = clip_sum(part, sum);
      for (std::size_t i = 0; i < part.size(); i += kClipIndexBytes)
        use(index_line_of(std::span<const std::byte, kClipIndexBytes>(&part[i], kClipIndexBytes)));
      at += part.size();
      lines -= count;
    }
    return sum;
  }

  void take_line(const ClipIndexLine& line) {
    if (line.type == static_cast<std::uint32_t>(ClipBlock::kFrame)) {
      add_entry({.camera_id = line.camera_id,
                 .number = line.number,
                 .t_capture_s = line.t_capture_s,
                 .place = line.place & kMaxPlace,
                 .has_memory = line.has_memory,
                 .is_whole = line.is_whole});
      return;
    }
    // Count the setup even if its block is damaged, so that its frames stay readable.
    if (line.type == static_cast<std::uint32_t>(ClipBlock::kSetup)) note_setup(line.number, line.place);
    std::array<std::byte, kClipBlockBytes> bytes{};
    read_at(line.place, bytes);
    const auto block = block_head_of(bytes);
    if (!block || block->type != line.type || block->camera_id != line.camera_id ||
        block->bytes != line.bytes)
      note(fmt::format("the block at byte {} is damaged", line.place));
    else
      take(*block, line.place);
  }

  /// Rebuilds the index from the block heads, up to the first damaged one.
  void scan(const std::stop_token& stop) {
    note("has no index: it was not finished, or is damaged");
    std::uint64_t place = kClipHeadBytes;
    while (place < size && size - place >= kClipBlockBytes) {
      if (stop.stop_requested()) refuse("was not read to the end");
      std::array<std::byte, kHeadsBytes> bytes{};
      read_at(place, std::span(bytes).first(std::min<std::uint64_t>(bytes.size(), size - place)));
      const auto head = block_head_of(std::span(bytes).first<kClipBlockBytes>());
      if (!head || !is_inside(place, head->bytes, size)) return;
      if (head->type != static_cast<std::uint32_t>(ClipBlock::kFrame)) {
        take(*head, place);
      } else if (const auto frame_head =
                     frame_head_of(std::span(bytes).last<kClipFrameBytes>(), head->bytes)) {
        add_entry(entry_of(*head, *frame_head, place));
        note_setup(frame_head->setup, place);
      }
      place += clip_block_bytes(head->bytes);
    }
  }

  static Entry entry_of(const ClipBlockHead& block, const ClipFrameHead& head, std::uint64_t place) {
    return {.camera_id = block.camera_id,
            .number = head.info.number,
            .t_capture_s = head.info.times.t_capture_s,
            .place = place & kMaxPlace,
            .has_memory = head.memory_bytes > 0,
            .is_whole = head.has_image()};
  }

  void add_entry(const Entry& entry) {
    if (entries.size() < kMaxClipBlocks && knows_camera(entry.camera_id)) return entries.push_back(entry);
    note(fmt::format("has more than {} frames or {} cameras; the rest is ignored", kMaxClipBlocks,
                     kMaxClipCameras));
  }
  bool knows_camera(std::uint32_t id) {
    if (!missing.contains(id) && missing.size() >= kMaxClipCameras) return false;
    missing.try_emplace(id, 0);
    return true;
  }

  /// Reads a block other than a frame. Skips damaged blocks and unknown types.
  void take(const ClipBlockHead& head, std::uint64_t place) {
    const auto type = static_cast<ClipBlock>(head.type);
    if (type != ClipBlock::kAbout && type != ClipBlock::kSetup && type != ClipBlock::kEvent &&
        type != ClipBlock::kMissing)
      return;
    const bool is_good = type == ClipBlock::kSetup ? take_setup(head, place) : take_known(type, head, place);
    if (!is_good) note(fmt::format("the block at byte {} is damaged", place));
  }

  bool take_known(ClipBlock type, const ClipBlockHead& head, std::uint64_t place) {
    const bool is_missing = type == ClipBlock::kMissing, is_event = type == ClipBlock::kEvent;
    if (is_missing) {
      if (head.bytes != kClipMissingBytes) return false;
    } else {
      if (head.bytes > std::min(kMaxClipEventBytes, json_left)) return false;
      if (is_event ? events.size() >= kMaxClipEvents : has_about) return false;
      json_left -= static_cast<std::size_t>(head.bytes);  // also if damaged, to bound the reading time
    }
    const auto payload = read_payload(head, place);
    if (!payload) return false;
    if (is_missing) {
      if (!knows_camera(head.camera_id)) return false;
      std::uint64_t& sum = missing[head.camera_id];
      sum += std::min(u64_at(*payload, 0), std::numeric_limits<std::uint64_t>::max() - sum);
      return true;
    }
    const Json json = json_in(*payload);
    if (!json.is_object()) return false;
    if (is_event) {
      events.push_back({number_in(json, "time_s"), text_in(json, "kind"), text_in(json, "text")});
      return true;
    }
    about = {.site = text_in(json, "site"),
             .version = text_in(json, "version"),
             .kind = text_in(json, "kind"),
             .why = text_in(json, "why"),
             .begin_s = number_in(json, "begin_s"),
             .end_s = number_in(json, "end_s")};
    if (!json.contains("kind") && about.why == kWhyOfOldCrashClips) about.kind = kCrashClip;
    has_about = true;
    return true;
  }

  /// Nullopt if the checksum is wrong. The caller must have checked the size.
  std::optional<std::vector<std::byte>> read_payload(const ClipBlockHead& head, std::uint64_t place) const {
    std::vector<std::byte> payload(static_cast<std::size_t>(head.bytes));
    read_at(place + kClipBlockBytes, payload);
    if (clip_sum(payload) != head.sum) return std::nullopt;
    return payload;
  }

  /// Only stores the setup's offset, because the table may be large, and few setups are read.
  bool take_setup(const ClipBlockHead& head, std::uint64_t place) {
    if (head.bytes < kClipSetupBytes ||
        head.bytes > kClipSetupBytes + kMaxClipJsonBytes + kMaxClipTableBytes || head.camera_id > INT_MAX)
      return false;
    std::array<std::byte, kClipSetupBytes> bytes{};
    read_at(place + kClipBlockBytes, bytes);
    const std::uint32_t number = u32_at(bytes, 0);
    if (!note_setup(number, place)) return false;
    setups[number] = place;
    return true;
  }

  /// Counts setup `number`. False if the number exceeds the limit for a clip, or if the file before `place`
  /// is too short for that number of setups.
  bool note_setup(std::uint32_t number, std::uint64_t place) {
    if (number >= std::min<std::uint64_t>(place / (kClipBlockBytes + kClipSetupBytes) + 1, kMaxClipSetups))
      return false;
    if (setups.size() <= number) setups.resize(std::size_t{number} + 1);
    return true;
  }

  ClipSetup setup(std::size_t number) const {
    ClipSetup none{.about = nullptr};
    if (number >= setups.size() || setups[number] == 0) return none;
    std::array<std::byte, kClipBlockBytes> bytes{};
    read_at(setups[number], bytes);
    const auto head = block_head_of(bytes);
    if (!head || head->type != static_cast<std::uint32_t>(ClipBlock::kSetup) ||
        head->bytes > kClipSetupBytes + kMaxClipJsonBytes + kMaxClipTableBytes || head->camera_id > INT_MAX)
      return none;
    auto payload = read_payload(*head, setups[number]);
    const auto parts = payload ? setup_in(*payload) : std::nullopt;
    if (!parts || parts->number != number) return none;
    Json json = json_in(parts->json);
    if (!json.is_object()) return none;
    // Keep the table in the buffer of the payload: a copy would double the memory.
    payload->erase(payload->begin(), payload->end() - static_cast<std::ptrdiff_t>(parts->table.size()));
    return {static_cast<int>(head->camera_id), std::move(json), *std::move(payload)};
  }

  void put_in_order() {
    // Keep each camera's frames in processing order, even if the clock was set back.
    std::map<std::uint32_t, double> latest_s;
    std::vector<std::pair<double, std::uint32_t>> order;
    order.reserve(entries.size());
    for (const Entry& entry : entries) {
      double& latest = latest_s.emplace(entry.camera_id, entry.t_capture_s).first->second;
      latest = std::max(latest, entry.t_capture_s);
      order.emplace_back(latest, static_cast<std::uint32_t>(order.size()));
    }
    std::ranges::stable_sort(order, {}, [](const auto& one) { return one.first; });
    // Permute in place, cycle by cycle, to save memory.
    for (std::uint32_t begin = 0; begin < order.size(); ++begin) {
      for (std::uint32_t to = begin; order[to].second != to;) {
        const std::uint32_t from = std::exchange(order[to].second, to);
        if (from == begin) break;
        std::swap(entries[to], entries[from]);
        to = from;
      }
    }
    std::map<std::uint32_t, std::size_t> counts;
    for (const Entry& entry : entries) ++counts[entry.camera_id];
    std::map<std::uint32_t, Camera> by_id;
    for (const auto& [id, count] : missing) {
      by_id[id].missing = count;
      by_id[id].frames.reserve(counts[id]);
    }
    for (std::uint32_t i = 0; i < entries.size(); ++i) by_id[entries[i].camera_id].frames.push_back(i);
    for (auto& [id, camera] : by_id) {
      camera.id = id;
      cameras.push_back(std::move(camera));
    }
    std::ranges::stable_sort(events, {}, &ClipEvent::time_s);
  }

  std::size_t max_image_bytes() const {
    constexpr std::size_t kOfAFrame = sizeof(Entry) + sizeof(std::uint32_t);
    return std::min(kMaxClipImageBytes, kMaxClipBytesInMemory - kOfAFrame * entries.size());
  }

  /// Reads the frame into `frame`. Returns why reading failed; empty if it succeeded.
  std::string read_into_frame(const Entry& entry, const Room& room) {
    std::array<std::byte, kHeadsBytes> heads{};
    read_at(entry.place, heads);
    const auto block = block_head_of(std::span(heads).first<kClipBlockBytes>());
    if (!block || block->type != static_cast<std::uint32_t>(ClipBlock::kFrame)) return "is damaged";
    const auto frame_head = std::span(heads).last<kClipFrameBytes>();
    const auto head = frame_head_of(frame_head, block->bytes);
    if (!head) return "is damaged";
    const Entry there = entry_of(*block, *head, entry.place);
    if (head->image_bytes > max_image_bytes())
      return fmt::format("has an image that is larger than {} MiB", max_image_bytes() >> 20U);
    const auto image_bytes = static_cast<std::size_t>(head->image_bytes);
    frame_bytes.resize(static_cast<std::size_t>(block->bytes) - kClipFrameBytes - image_bytes);
    std::uint8_t* pixels = nullptr;
    if (image_bytes > 0) {
      const bool is_theirs = room && head->has_image();
      if (!is_theirs) {
        if (image.capacity() < image_bytes) image = std::vector<std::uint8_t>();  // frees the old image first
        image.resize(image_bytes);
      }
      pixels = is_theirs ? room(image_bytes) : image.data();
      if (pixels == nullptr) refuse("there is not enough memory for an image");
    }
    const auto image_there = std::as_writable_bytes(std::span(pixels, image_bytes));
    read_at(entry.place + kHeadsBytes, frame_bytes, image_there);
    if (clip_sum(image_there, clip_sum(frame_bytes, clip_sum(frame_head))) != block->sum) return "is damaged";
    if (there.camera_id != entry.camera_id || there.number != entry.number ||
        there.t_capture_s != entry.t_capture_s || there.has_memory != entry.has_memory ||
        there.is_whole != entry.is_whole)
      return "does not match the index";
    if (head->setup >= setups.size()) return "has a setup that is not in the clip";
    frame = frame_of(*head, block->camera_id, frame_bytes, head->has_image() ? pixels : nullptr);
    return "";
  }

  const ClipFrame& read(std::size_t place, const Room& room) {
    if (place >= entries.size())
      refuse(fmt::format("has {} frames, but none at index {}", entries.size(), place));
    const Entry& entry = entries[place];
    const std::string why = read_into_frame(entry, room);
    if (why.empty()) return frame;
    refuse(fmt::format("frame {} of camera {} {}", entry.number, entry.camera_id, why));
  }

  const std::string name;
  const int fd;
  std::uint64_t size = 0;
  bool is_unfinished = false, has_about = false;
  std::string problem;
  ClipAbout about;
  std::vector<Entry> entries;
  std::vector<Camera> cameras;
  std::vector<std::uint64_t> setups;                // offsets of the setups' blocks; 0: missing
  std::size_t json_left = kMaxClipEventBytesInAll;  // JSON bytes that may still be read
  std::vector<ClipEvent> events;
  std::map<std::uint32_t, std::uint64_t> missing;  // missing frames of each known camera

  ClipFrame frame;                     // the last frame read
  std::vector<std::byte> frame_bytes;  // packet and memory of `frame`
  std::vector<std::uint8_t> image;
};

ClipReader::ClipReader(const std::filesystem::path& file, const std::stop_token& stop)
    : file_(std::make_unique<File>(file, stop)) {}

ClipReader::~ClipReader() = default;

ClipReader::ClipReader(ClipReader&&) noexcept = default;

ClipReader& ClipReader::operator=(ClipReader&&) noexcept = default;

const ClipAbout& ClipReader::about() const {
  return file_->about;
}

const std::vector<ClipReader::Entry>& ClipReader::entries() const {
  return file_->entries;
}

const std::vector<ClipReader::Camera>& ClipReader::cameras() const {
  return file_->cameras;
}

const ClipReader::Camera* ClipReader::camera(std::uint32_t id) const {
  const auto found = std::ranges::find(file_->cameras, id, &Camera::id);
  return found != file_->cameras.end() ? &*found : nullptr;
}

std::size_t ClipReader::setup_count() const {
  return file_->setups.size();
}

ClipSetup ClipReader::setup(std::size_t number) const {
  return file_->setup(number);
}

const std::vector<ClipEvent>& ClipReader::events() const {
  return file_->events;
}

bool ClipReader::is_unfinished() const {
  return file_->is_unfinished;
}

const std::string& ClipReader::problem() const {
  return file_->problem;
}

const ClipFrame& ClipReader::read(std::size_t place) {
  return file_->read(place, {});
}

const ClipFrame& ClipReader::read(std::size_t place,
                                  const std::function<std::uint8_t*(std::size_t bytes)>& room) {
  return file_->read(place, room);
}

}  // namespace sslv
