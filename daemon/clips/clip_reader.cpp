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

std::string text_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? escaped_text(found->get<std::string>()) : std::string();
}

double number_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0;
}

/// A block of which only its size is known: nothing is read of it.
struct BlockPlace {
  std::uint64_t place = 0, bytes = 0;
};

/// A whole image that others are put onto.
struct BaseImage {
  std::uint64_t place = 0;
  ClipFrameHead head;
  std::vector<std::uint8_t> pixels{};
};

bool is_same_layout(const ClipFrameHead& a, const ClipFrameHead& b) {
  return a.width == b.width && a.height == b.height && a.format == b.format && a.is_deep == b.is_deep;
}

std::size_t image_bytes_of(const ClipFrameHead& head) {
  if (head.width == 0) return 0;
  return clip_plane_bytes(head.format, head.width, head.height) * (head.is_deep ? 2 : 1);
}

/// Puts the pixels of the marked tiles where they belong.
void put_tiles(const ClipFrameHead& head, std::span<const std::byte> map, std::span<const std::byte> pixels,
               std::uint8_t* image) {
  const ClipTiles grid{head.width, head.height, head.tile_px};
  const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(head.format));
  const std::size_t row_bytes = clip_plane_bytes(head.format, head.width, 1);
  const std::byte* from = pixels.data();
  for (int plane = 0; plane < (head.is_deep ? 2 : 1); ++plane) {
    grid.each_row(map, [&](int x, int y, int count) {
      const std::size_t bytes = static_cast<std::size_t>(count) * pixel_bytes;
      std::memcpy(image + static_cast<std::size_t>(y) * row_bytes + static_cast<std::size_t>(x) * pixel_bytes,
                  from, bytes);
      from += bytes;
    });
    image += clip_plane_bytes(head.format, head.width, head.height);
  }
}

}  // namespace

struct ClipReader::File {
  using Room = std::function<std::uint8_t*(std::size_t bytes)>;

  File(const std::filesystem::path& path, const std::stop_token& stop)
      : name(path.string()),
        // A pipe would wait for somebody who writes into it.
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

  /// Fills two pieces of memory, one after the other, from `place` on.
  void read_at(std::uint64_t place, std::span<std::byte> first, std::span<std::byte> second = {}) const {
    while (!first.empty() || !second.empty()) {
      const std::array<iovec, 2> parts{{{first.data(), first.size()}, {second.data(), second.size()}}};
      const ssize_t count = ::preadv(fd, parts.data(), 2, static_cast<off_t>(place));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
      if (count == 0) refuse("has become shorter while it was read");
      const auto got = static_cast<std::size_t>(count);
      place += got;
      const std::size_t of_first = std::min(got, first.size());
      first = first.subspan(of_first);
      second = second.subspan(got - of_first);
    }
  }

  /// False where a block cannot lie whole in the file.
  bool is_inside(std::uint64_t place, std::uint64_t payload_bytes, std::uint64_t end) const {
    return place >= kClipHeadBytes && place <= end && end - place >= kClipBlockBytes &&
           payload_bytes <= end - place - kClipBlockBytes;
  }

  void open(const std::stop_token& stop) {
    struct stat status {};
    if (::fstat(fd, &status) != 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (!S_ISREG(status.st_mode)) refuse("is no clip: it is no file");
    size = static_cast<std::uint64_t>(status.st_size);
    check_head();
    if (!read_index()) {
      is_unfinished = true;
      scan(stop);
    }
    put_in_order();
    if (!has_about) note("what it says about itself is missing or damaged");
    ::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
  }

  void check_head() const {
    std::array<std::byte, kClipHeadBytes> head{};
    const auto there = std::span(head).first(std::min<std::uint64_t>(size, head.size()));
    read_at(0, there);
    const auto known = clip_head();
    if (there.empty()) refuse("is no clip: it is empty");
    if (std::ranges::equal(there, known)) return;
    constexpr std::size_t kName = kClipMagic.size() - 3;  // without the line ends
    if (!std::ranges::equal(there.first(std::min(there.size(), kName)),
                            std::span(known).first(std::min(there.size(), kName))))
      refuse("is no clip: it does not begin like one");
    if (there.size() < head.size()) refuse("is no clip: it ends in its head");
    if (!std::ranges::equal(there.first(kClipMagic.size()), std::span(known).first(kClipMagic.size())))
      refuse("was changed by a transfer as text; transfer it as binary");
    refuse(fmt::format("version {} of clips is not known; expected {}", u32_at(head, kClipMagic.size()),
                       kClipVersion));
  }

  /// False when there is none that could be right.
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
    std::vector<std::byte> lines(static_cast<std::size_t>(head->bytes));
    read_at(*place + kClipBlockBytes, lines);
    if (clip_sum(lines) != head->sum) return false;

    std::uint64_t free = kClipHeadBytes;  // the blocks before end here
    for (std::size_t i = 0; i < lines.size(); i += kClipIndexBytes) {
      const ClipIndexLine line =
          index_line_of(std::span<const std::byte, kClipIndexBytes>(&lines[i], kClipIndexBytes));
      if (line.place < free || line.place % 8 != 0 || !is_inside(line.place, line.bytes, *place))
        return false;
      if (line.type == static_cast<std::uint32_t>(ClipBlock::kFrame) &&
          (line.bytes < kClipFrameBytes || !std::isfinite(line.t_capture_s)))
        return false;
      free = line.place + clip_block_bytes(line.bytes);
    }
    for (std::size_t i = 0; i < lines.size(); i += kClipIndexBytes) {
      const ClipIndexLine line =
          index_line_of(std::span<const std::byte, kClipIndexBytes>(&lines[i], kClipIndexBytes));
      if (line.type == static_cast<std::uint32_t>(ClipBlock::kFrame)) {
        found.push_back({{.camera_id = line.camera_id,
                          .number = line.number,
                          .t_capture_s = line.t_capture_s,
                          .has_memory = line.has_memory,
                          .is_whole = line.is_whole},
                         {line.place, line.bytes}});
        continue;
      }
      if (line.type == static_cast<std::uint32_t>(ClipBlock::kSetup) && line.number < most_setups(line.place))
        setups_used = std::max<std::size_t>(setups_used, std::size_t{line.number} + 1);
      read_at(line.place, bytes);
      const auto block = block_head_of(bytes);
      if (!block || block->type != line.type || block->camera_id != line.camera_id ||
          block->bytes != line.bytes)
        note(fmt::format("the block at byte {} is damaged", line.place));
      else
        take(*block, line.place);
    }
    return true;
  }

  /// From block to block, as far as they can be read.
  void scan(const std::stop_token& stop) {
    note("has no end: it was not finished, or is damaged");
    std::uint64_t place = kClipHeadBytes;
    while (place < size && size - place >= kClipBlockBytes) {
      if (stop.stop_requested()) refuse("was not read to its end");
      std::array<std::byte, kHeadsBytes> bytes{};
      read_at(place, std::span(bytes).first(std::min<std::uint64_t>(bytes.size(), size - place)));
      const auto head = block_head_of(std::span(bytes).first<kClipBlockBytes>());
      if (!head || !is_inside(place, head->bytes, size)) return;
      if (head->type != static_cast<std::uint32_t>(ClipBlock::kFrame)) {
        take(*head, place);
      } else if (const auto frame_head =
                     frame_head_of(std::span(bytes).last<kClipFrameBytes>(), head->bytes, place)) {
        found.push_back({entry_of(*head, *frame_head), {place, head->bytes}});
        // What it was processed with may be damaged; the frame is there all the same.
        if (frame_head->setup < most_setups(place))
          setups_used = std::max<std::size_t>(setups_used, std::size_t{frame_head->setup} + 1);
      }
      place += clip_block_bytes(head->bytes);
    }
  }

  static Entry entry_of(const ClipBlockHead& block, const ClipFrameHead& head) {
    return {.camera_id = block.camera_id,
            .number = head.info.number,
            .t_capture_s = head.info.times.t_capture_s,
            .has_memory = head.memory_bytes > 0,
            .is_whole = head.tile_px == 0 && head.width > 0};
  }

  /// A block that is no frame. What is damaged is left out; what is not known, too.
  void take(const ClipBlockHead& head, std::uint64_t place) {
    const auto type = static_cast<ClipBlock>(head.type);
    if (type != ClipBlock::kAbout && type != ClipBlock::kSetup && type != ClipBlock::kEvent &&
        type != ClipBlock::kMissing)
      return;
    const std::size_t most = kMaxClipJsonBytes + (type == ClipBlock::kSetup ? kMaxClipTableBytes : 0);
    if (head.bytes > most || !take_known(type, head, place))
      note(fmt::format("the block at byte {} is damaged", place));
  }

  bool take_known(ClipBlock type, const ClipBlockHead& head, std::uint64_t place) {
    std::vector<std::byte> payload(static_cast<std::size_t>(head.bytes));
    read_at(place + kClipBlockBytes, payload);
    if (clip_sum(payload) != head.sum) return false;
    if (type == ClipBlock::kMissing) {
      if (payload.size() < kClipMissingBytes) return false;
      std::uint64_t& sum = missing[head.camera_id];
      sum += std::min(u64_at(payload, 0), std::numeric_limits<std::uint64_t>::max() - sum);
      return true;
    }
    if (type == ClipBlock::kSetup) return take_setup(head, place, payload);
    const Json json = json_in(payload);
    if (!json.is_object()) return false;
    if (type == ClipBlock::kEvent) {
      events.push_back({number_in(json, "time_s"), text_in(json, "kind"), text_in(json, "text")});
      return true;
    }
    about = {.site = text_in(json, "site"),
             .version = text_in(json, "version"),
             .why = text_in(json, "why"),
             .begin_s = number_in(json, "begin_s"),
             .end_s = number_in(json, "end_s")};
    has_about = true;
    return true;
  }

  bool take_setup(const ClipBlockHead& head, std::uint64_t place, std::span<const std::byte> payload) {
    if (payload.size() < kClipSetupBytes || head.camera_id > INT_MAX) return false;
    const std::uint32_t number = u32_at(payload, 0);
    const std::uint64_t text_bytes = u64_at(payload, 8);
    payload = payload.subspan(kClipSetupBytes);
    if (number >= most_setups(place) || text_bytes > payload.size()) return false;
    const auto text = payload.first(static_cast<std::size_t>(text_bytes));
    Json json = json_in(text);
    if (!json.is_object()) return false;
    const auto table = payload.subspan(text.size());
    if (table.size() > kMaxClipTableBytes || table.size() > kMaxClipTableBytesInAll - table_bytes)
      return false;
    table_bytes += table.size();
    reserve_setups(std::size_t{number} + 1);
    setups[number] = {static_cast<int>(head.camera_id), std::move(json), {table.begin(), table.end()}};
    return true;
  }

  /// More cannot have been written before `place` and by the block there, so that a number that lies costs no
  /// more memory than the file has.
  static constexpr std::uint64_t most_setups(std::uint64_t place) {
    return std::min<std::uint64_t>(place / (kClipBlockBytes + kClipSetupBytes) + 1, kMaxClipSetups);
  }
  void reserve_setups(std::size_t count) {
    while (setups.size() < count) setups.push_back({.camera_id = 0, .about = nullptr});
  }

  /// Null where it is none, or too much.
  Json json_in(std::span<const std::byte> payload) {
    if (payload.size() > kMaxClipJsonBytes || payload.size() > kMaxClipJsonBytesInAll - json_bytes)
      return nullptr;
    json_bytes += payload.size();
    try {
      return parse_bounded_json({reinterpret_cast<const char*>(payload.data()), payload.size()});
    } catch (const Json::exception&) {
    } catch (const std::length_error&) {
    }
    return nullptr;
  }

  void put_in_order() {
    reserve_setups(setups_used);
    // A camera's frames stay as they were processed, also where the clock was set back meanwhile.
    std::map<std::uint32_t, double> latest_s;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Entry& entry = found[i].first;
      double& latest = latest_s.emplace(entry.camera_id, entry.t_capture_s).first->second;
      latest = std::max(latest, entry.t_capture_s);
      order.emplace_back(latest, i);
    }
    std::ranges::stable_sort(order, {}, [](const auto& one) { return one.first; });
    std::map<std::uint32_t, Camera> by_id;
    for (const auto& [id, count] : missing) by_id[id].missing = count;
    for (const auto& [time_s, i] : order) {
      const auto& [entry, place] = found[i];
      by_id[entry.camera_id].frames.push_back(entries.size());
      entries.push_back(entry);
      places.push_back(place);
    }
    found = {};
    for (auto& [id, camera] : by_id) {
      camera.id = id;
      cameras.push_back(std::move(camera));
    }
    std::ranges::stable_sort(events, {}, &ClipEvent::time_s);
  }

  /// A frame's block as it lies in the file: its image, or the pixels of its tiles, is in `pixels`.
  struct Loaded {
    ClipBlockHead block;
    ClipFrameHead head;
    std::span<const std::byte> packet{}, memory{}, tiles{}, tile_pixels{};
    std::uint8_t* image = nullptr;  // of a whole one
  };

  /// None where it is damaged. `rest` holds all but a whole image, which is read into `room`'s memory.
  std::optional<Loaded> load(const BlockPlace& at, std::vector<std::byte>& rest, const Room& room) const {
    std::array<std::byte, kHeadsBytes> heads{};
    read_at(at.place, heads);
    const auto block = block_head_of(std::span(heads).first<kClipBlockBytes>());
    if (!block || block->type != static_cast<std::uint32_t>(ClipBlock::kFrame) || block->bytes != at.bytes)
      return std::nullopt;
    const auto head = frame_head_of(std::span(heads).last<kClipFrameBytes>(), block->bytes, at.place);
    if (!head) return std::nullopt;
    Loaded out{.block = *block, .head = *head};
    const bool is_whole = head->tile_px == 0;
    const auto image_bytes = static_cast<std::size_t>(head->image_bytes);
    rest.resize(static_cast<std::size_t>(block->bytes) - kClipFrameBytes - (is_whole ? image_bytes : 0));
    std::span<std::byte> pixels;
    if (is_whole && image_bytes > 0) {
      out.image = room(image_bytes);
      if (out.image == nullptr) refuse("there is no memory for an image");
      pixels = std::as_writable_bytes(std::span(out.image, image_bytes));
    }
    read_at(at.place + kHeadsBytes, rest, pixels);
    std::uint32_t sum = clip_sum(std::span(heads).last<kClipFrameBytes>());
    sum = clip_sum(rest, sum);
    if (clip_sum(pixels, sum) != block->sum) return std::nullopt;
    std::span<const std::byte> left = rest;
    const auto cut = [&](std::uint64_t bytes) {
      const auto part = left.first(static_cast<std::size_t>(bytes));
      left = left.subspan(part.size());
      return part;
    };
    out.packet = cut(head->packet_bytes);
    out.memory = cut(head->memory_bytes);
    out.tiles = cut(head->tiles_bytes);
    out.tile_pixels = left;
    return out;
  }

  /// The whole image that `parts` lie on; null where there is none that fits.
  const BaseImage* base_of(const Loaded& parts) {
    if (!bases.contains(parts.block.camera_id)) {
      constexpr std::size_t kMostBytes = std::size_t{256} << 20U;  // eight large cameras'
      std::size_t bytes = image_bytes_of(parts.head);
      for (const auto& [id, base] : bases) bytes += base.pixels.size();
      if (bytes > kMostBytes) bases.clear();
    }
    BaseImage& base = bases[parts.block.camera_id];
    if (base.place != parts.head.base || base.place == 0) {
      base.place = 0;
      const std::uint64_t place = parts.head.base;
      if (!is_inside(place, kClipFrameBytes, size)) return nullptr;
      std::array<std::byte, kClipBlockBytes> bytes{};
      read_at(place, bytes);
      const auto block = block_head_of(bytes);
      if (!block || block->camera_id != parts.block.camera_id || block->bytes < kClipFrameBytes ||
          !is_inside(place, block->bytes, size))
        return nullptr;
      std::vector<std::byte> rest;
      const auto loaded = load({place, block->bytes}, rest, [&](std::size_t image_bytes) {
        base.pixels.resize(image_bytes);
        return base.pixels.data();
      });
      if (!loaded || loaded->image == nullptr) return nullptr;
      base.head = loaded->head;
      base.place = place;
    }
    return is_same_layout(base.head, parts.head) ? &base : nullptr;
  }

  /// Why the frame cannot be given; empty: it is in `frame`.
  const char* read_into_frame(std::size_t place, const Room& room) {
    const Room own_or_room = [&](std::size_t bytes) -> std::uint8_t* {
      if (room) return room(bytes);
      image.resize(bytes);
      return image.data();
    };
    const Entry& entry = entries[place];
    const auto loaded = load(places[place], frame_bytes, own_or_room);
    if (!loaded) return "is damaged";
    const ClipFrameHead& head = loaded->head;
    const Entry there = entry_of(loaded->block, head);
    if (there.camera_id != entry.camera_id || there.number != entry.number ||
        there.t_capture_s != entry.t_capture_s || there.has_memory != entry.has_memory ||
        there.is_whole != entry.is_whole)
      return "is not what the index says";
    if (head.setup >= setups.size()) return "has a setup that is not in the clip";
    std::uint8_t* pixels = loaded->image;
    if (head.tile_px != 0) {
      const ClipTiles grid{head.width, head.height, head.tile_px};
      const std::uint64_t tile_bytes = grid.pixels(loaded->tiles) *
                                       static_cast<std::uint64_t>(bytes_per_pixel(head.format)) *
                                       (head.is_deep ? 2 : 1);
      if (tile_bytes != head.image_bytes) return "is damaged";
      const BaseImage* base = base_of(*loaded);
      if (base == nullptr) return "cannot be put together: the whole image before it is missing or damaged";
      pixels = own_or_room(base->pixels.size());
      if (pixels == nullptr) refuse("there is no memory for an image");
      std::memcpy(pixels, base->pixels.data(), base->pixels.size());
      put_tiles(head, loaded->tiles, loaded->tile_pixels, pixels);
    }
    frame.info = head.info;
    frame.info.camera_id = loaded->block.camera_id;
    frame.setup = head.setup;
    frame.image = {};
    if (pixels != nullptr) {
      frame.image = {
          .data = pixels,
          .width = head.width,
          .height = head.height,
          .stride_bytes = static_cast<std::ptrdiff_t>(clip_plane_bytes(head.format, head.width, 1)),
          .format = head.format};
      if (head.is_deep) frame.image.to_low_bits = static_cast<std::ptrdiff_t>(image_bytes_of(head) / 2);
    }
    frame.tile_px = head.tile_px;
    frame.tiles = loaded->tiles;
    frame.packet = loaded->packet;
    frame.memory = loaded->memory;
    return "";
  }

  const ClipFrame& read(std::size_t place, const Room& room) {
    if (place >= entries.size()) refuse(fmt::format("has {} frames, not one at {}", entries.size(), place));
    const std::string_view why = read_into_frame(place, room);
    if (why.empty()) return frame;
    const Entry& entry = entries[place];
    refuse(fmt::format("frame {} of camera {} {}", entry.number, entry.camera_id, why));
  }

  const std::string name;
  const int fd;
  std::uint64_t size = 0;
  bool is_unfinished = false, has_about = false;
  std::string problem;
  ClipAbout about;
  std::vector<std::pair<Entry, BlockPlace>> found;  // while it is opened
  std::vector<Entry> entries;
  std::vector<BlockPlace> places;  // of entries
  std::vector<Camera> cameras;
  std::vector<ClipSetup> setups;
  std::size_t setups_used = 0, json_bytes = 0, table_bytes = 0;
  std::vector<ClipEvent> events;
  std::map<std::uint32_t, std::uint64_t> missing;

  ClipFrame frame;                     // the last that was read
  std::vector<std::byte> frame_bytes;  // its parts
  std::vector<std::uint8_t> image;
  std::map<std::uint32_t, BaseImage> bases;  // by camera
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

const std::vector<ClipSetup>& ClipReader::setups() const {
  return file_->setups;
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
