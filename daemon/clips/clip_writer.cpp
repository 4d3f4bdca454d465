// SPDX-License-Identifier: Apache-2.0
#include "clips/clip_writer.h"

#include "base/error.h"
#include "clips/clip_format.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

namespace sslv {
namespace {

/// Writeback starts at this number of unwritten bytes in the page cache, which therefore holds at most twice
/// that number. More would evict the pages of other programs, and a slow disk would then block the writer for
/// long.
constexpr std::uint64_t kMaxUnwrittenBytes = 32ULL << 20U;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

struct ClipWriter::File {
  File(const std::filesystem::path& path, const ClipAbout& about, std::uint64_t most_blocks)
      : name(path.string()),
        fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640)),
        max_blocks(most_blocks) {
    if (fd < 0) fail();
    folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    try {
      const auto head = clip_head();
      parts.clear();
      add_part(head);
      write_parts(head.size());
      const std::string text = limited_text({{"format", "ssl-visiond clip"},
                                             {"site", about.site},
                                             {"version", about.version},
                                             {"kind", about.kind},
                                             {"why", about.why},
                                             {"begin_s", about.begin_s},
                                             {"end_s", about.end_s}},
                                            kMaxClipEventBytes);
      event_bytes = text.size();
      write_block(ClipBlock::kAbout, 0, clip_ns(about.begin_s), {bytes_of(text)}, {});
    } catch (...) {
      ::close(fd);
      throw;
    }
  }
  ~File() { ::close(fd); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[noreturn]] void fail() const {
    throw StorageError(fmt::format("{}: cannot be written: {}", name, std::strerror(errno)));
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw StorageError(fmt::format("{}: {}", name, why));
  }

  /// Throws StorageError if the text is longer than `max_bytes`.
  std::string limited_text(const Json& json, std::size_t max_bytes) {
    std::string text = json_text(json);
    if (text.size() > max_bytes)
      refuse(fmt::format("settings of a clip are limited to {} MiB, events to {} KiB each",
                         kMaxClipJsonBytes >> 20U, kMaxClipEventBytes >> 10U));
    return text;
  }

  void add_part(std::span<const std::byte> part) {
    if (part.empty()) return;
    parts.push_back({const_cast<std::byte*>(part.data()), part.size()});  // writev only reads it
  }

  /// Appends `parts` to the file. Truncates the file again after a partial write, so that it ends with a
  /// complete block.
  void write_parts(std::uint64_t count) {
    if (is_broken) refuse("cannot be written: it could not be shortened after an earlier error");
    std::size_t done = 0;
    while (done < parts.size()) {
      const std::size_t some = std::min<std::size_t>(parts.size() - done, IOV_MAX);
      ssize_t got = ::writev(fd, &parts[done], static_cast<int>(some));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        const int why = errno;
        is_broken = ::ftruncate(fd, static_cast<off_t>(size)) != 0 ||
                    ::lseek(fd, static_cast<off_t>(size), SEEK_SET) < 0;
        errno = why;
        fail();
      }
      for (; done < parts.size() && static_cast<std::size_t>(got) >= parts[done].iov_len; ++done)
        got -= static_cast<ssize_t>(parts[done].iov_len);
      if (got == 0) continue;
      parts[done].iov_base = static_cast<char*>(parts[done].iov_base) + got;
      parts[done].iov_len -= static_cast<std::size_t>(got);
    }
    size += count;
  }

  /// Starts writeback of the new range, waits for writeback of the previous range, and drops the previous
  /// range from the page cache.
  void hand_on() {
    sync_range(handed_on, size - handed_on, SYNC_FILE_RANGE_WRITE);
    if (handed_on > written)
      sync_range(written, handed_on - written,
                 SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
    ::posix_fadvise(fd, 0, static_cast<off_t>(handed_on), POSIX_FADV_DONTNEED);
    written = handed_on;
    handed_on = size;
  }
  /// Throws on disk errors, which the kernel reports only once. On file systems that do not support ranges,
  /// the sync in finish() is enough.
  void sync_range(std::uint64_t begin, std::uint64_t count, unsigned how) const {
    if (::sync_file_range(fd, static_cast<off_t>(begin), static_cast<off_t>(count), how) == 0) return;
    if (errno == EIO || errno == ENOSPC || errno == EDQUOT) fail();
  }

  void write_block(ClipBlock type, std::uint32_t camera_id, std::int64_t time_ns,
                   std::initializer_list<std::span<const std::byte>> payload, ClipIndexLine line) {
    parts.assign(1, {});
    std::uint32_t sum = 0;
    std::uint64_t count = 0;
    for (const std::span<const std::byte> part : payload) {
      sum = clip_sum(part, sum);
      count += part.size();
      add_part(part);
    }
    finish_block(type, camera_id, time_ns, sum, count, line);
  }

  /// Writes a block. Its payload is in parts[1] and the following parts.
  void finish_block(ClipBlock type, std::uint32_t camera_id, std::int64_t time_ns, std::uint32_t sum,
                    std::uint64_t count, ClipIndexLine line) {
    const auto head = encoded(ClipBlockHead{.type = static_cast<std::uint32_t>(type),
                                            .camera_id = camera_id,
                                            .bytes = count,
                                            .time_ns = time_ns,
                                            .sum = sum});
    if (blocks() >= max_blocks && type != ClipBlock::kIndex)
      refuse(fmt::format("is full: a clip has at most {} frames", max_blocks));
    parts[0] = {const_cast<std::byte*>(head.data()), head.size()};
    if (size - handed_on >= kMaxUnwrittenBytes) hand_on();
    constexpr std::array<std::byte, 8> kPadding{};
    add_part(std::span(kPadding).first(clip_padding(count)));
    line.place = size;
    line.bytes = count;
    line.type = static_cast<std::uint32_t>(type);
    line.camera_id = camera_id;
    const auto in_index = encoded(line);
    // Allocate before writing: a written block must be in the index.
    if (index.capacity() - index.size() < in_index.size()) index.reserve(2 * index.size() + 4096);
    write_parts(clip_block_bytes(count));
    index.insert(index.end(), in_index.begin(), in_index.end());
  }
  std::uint64_t blocks() const { return index.size() / kClipIndexBytes; }

  /// Adds the rows of the plane that begins `offset` bytes after the image's data, also to the checksum
  /// `sum`.
  void add_plane(const ImageView& image, std::ptrdiff_t offset, std::uint32_t& sum) {
    const std::size_t row_bytes = clip_plane_bytes(image.format, image.width, 1);
    const bool is_tight = image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes);
    const std::size_t piece = is_tight ? row_bytes * static_cast<std::size_t>(image.height) : row_bytes;
    for (int y = 0; y < (is_tight ? 1 : image.height); ++y) {
      const auto rows = std::as_bytes(std::span(image.row(y) + offset, piece));
      sum = clip_sum(rows, sum);
      add_part(rows);
    }
  }

  const std::string name;
  std::filesystem::path folder;
  const int fd;
  const std::uint64_t max_blocks;
  std::uint64_t size = 0;
  std::uint64_t handed_on = 0, written = 0;  // end of the range under writeback; end of the range on the disk
  bool is_broken = false;
  std::vector<iovec> parts;      // parts of the current block
  std::vector<std::byte> index;  // lines encoded as in the file
  std::uint32_t setups = 0;
  std::size_t events = 0, event_bytes = 0;
};

ClipWriter::ClipWriter(const std::filesystem::path& file, const ClipAbout& about, std::uint64_t max_blocks)
    : file_(std::make_unique<File>(file, about, max_blocks)) {}

ClipWriter::~ClipWriter() = default;

std::uint32_t ClipWriter::add(const ClipSetup& setup) {
  const std::string text = file_->limited_text(setup.about, kMaxClipJsonBytes);
  return add_setup(static_cast<std::uint32_t>(setup.camera_id), bytes_of(text), setup.table);
}

std::uint32_t ClipWriter::add_setup(std::uint32_t camera_id, std::span<const std::byte> json,
                                    std::span<const std::byte> table) {
  if (file_->setups >= kMaxClipSetups || table.size() > kMaxClipTableBytes)
    file_->refuse(fmt::format("a clip has at most {} setups, with tables of at most {} MiB", kMaxClipSetups,
                              kMaxClipTableBytes >> 20U));
  const auto head = setup_head(file_->setups, json.size());
  ClipIndexLine line;
  line.number = file_->setups;
  file_->write_block(ClipBlock::kSetup, camera_id, 0, {head, json, table}, line);
  return file_->setups++;
}

void ClipWriter::add(const ClipFrame& frame) {
  const ImageView& image = frame.image;
  const std::uint32_t camera_id = frame.info.camera_id;
  if (frame.setup >= file_->setups)
    file_->refuse(fmt::format("a frame of camera {} has setup {}, but {} were added", camera_id, frame.setup,
                              file_->setups));
  const bool is_good = image.empty() || (is_valid_size(image.format, image.width, image.height) &&
                                         clip_image_bytes(image) <= kMaxClipImageBytes);
  if (!is_good)
    file_->refuse(fmt::format("a frame of camera {} has {}x{} px, which a clip cannot hold", camera_id,
                              image.width, image.height));
  ClipFrameHead head;
  head.info = frame.info;
  if (!std::isfinite(head.info.times.t_capture_s))
    file_->refuse(fmt::format("a frame of camera {} has no time", camera_id));
  leave_out_bad_times(head.info.times);
  head.setup = frame.setup;
  head.format = image.format;
  head.packet_bytes = frame.packet.size();
  head.memory_bytes = frame.memory.size();
  head.image_bytes = clip_image_bytes(image);
  if (!image.empty()) {
    head.width = image.width;
    head.height = image.height;
    head.is_deep = image.to_low_bits != 0;
  }

  const auto head_bytes = encoded(head);
  file_->parts.assign(1, {});
  std::uint32_t sum = 0;
  for (const std::span<const std::byte> part :
       {std::span<const std::byte>(head_bytes), frame.packet, frame.memory}) {
    sum = clip_sum(part, sum);
    file_->add_part(part);
  }
  if (!image.empty()) file_->add_plane(image, 0, sum);
  if (head.is_deep) file_->add_plane(image, image.to_low_bits, sum);
  ClipIndexLine line;
  line.t_capture_s = head.info.times.t_capture_s;
  line.number = head.info.number;
  line.has_memory = head.memory_bytes > 0;
  line.is_whole = !image.empty();
  file_->finish_block(ClipBlock::kFrame, camera_id, clip_ns(line.t_capture_s), sum,
                      kClipFrameBytes + head.packet_bytes + head.memory_bytes + head.image_bytes, line);
}

void ClipWriter::add(const ClipEvent& event) {
  const std::string text = file_->limited_text(
      {{"time_s", event.time_s}, {"kind", event.kind}, {"text", event.text}}, kMaxClipEventBytes);
  if (file_->events >= kMaxClipEvents || text.size() > kMaxClipEventBytesInAll - file_->event_bytes)
    file_->refuse(fmt::format("a clip has at most {} events, of {} MiB together", kMaxClipEvents,
                              kMaxClipEventBytesInAll >> 20U));
  file_->write_block(ClipBlock::kEvent, 0, clip_ns(event.time_s), {bytes_of(text)}, {});
  ++file_->events;
  file_->event_bytes += text.size();
}

void ClipWriter::note_missing(std::uint32_t camera_id, std::uint64_t frames) {
  std::array<std::byte, kClipMissingBytes> bytes{};
  put_u64(bytes, 0, frames);
  file_->write_block(ClipBlock::kMissing, camera_id, 0, {bytes}, {});
}

void ClipWriter::finish() {
  const std::uint64_t place = file_->size;
  file_->index.reserve(file_->index.size() + kClipIndexBytes);  // no reallocation while it is written
  file_->write_block(ClipBlock::kIndex, 0, 0, {file_->index}, {});
  const auto trailer = clip_trailer(place);
  file_->parts.clear();
  file_->add_part(trailer);
  file_->write_parts(trailer.size());
  if (::fdatasync(file_->fd) != 0) file_->fail();
  const int folder = ::open(file_->folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) file_->fail();
  const bool is_there = ::fsync(folder) == 0;
  const int why = errno;
  ::close(folder);
  errno = why;
  if (!is_there) file_->fail();
  ::posix_fadvise(file_->fd, 0, 0, POSIX_FADV_DONTNEED);
}

std::uint64_t ClipWriter::bytes() const {
  return file_->size;
}

bool ClipWriter::is_full() const {
  return file_->blocks() + kClipEndBlocks >= file_->max_blocks;
}

}  // namespace sslv
