// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_writer.h"

#include "base/error.h"
#include "base/log.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

constexpr int kGzip = 16 + MAX_WBITS;
constexpr std::size_t kOutputBytes = 128 * 1024;

std::string why() {
  return std::strerror(errno);
}

/// A file to append to. Errors throw StorageError.
class OutputFile {
 public:
  OutputFile(const fs::path& path, int flags)
      : name_(path.string()), file_(::open(path.c_str(), flags, 0640)) {
    if (file_ < 0) fail("cannot be written");
  }
  ~OutputFile() {
    if (file_ >= 0) ::close(file_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::span<const Bytef> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(file_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail("cannot be written");
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }
  void sync() {
    if (::fdatasync(file_) != 0) fail("cannot be written");
  }
  /// Throws StorageError if the file was removed or replaced.
  void check_name() const {
    struct stat mine {
    }, named{};
    if (::fstat(file_, &mine) != 0 || ::stat(name_.c_str(), &named) != 0 || mine.st_ino != named.st_ino ||
        mine.st_dev != named.st_dev)
      throw StorageError(fmt::format("{}: was removed or replaced while it was being written", name_));
  }
  void cut(std::uint64_t size) {
    if (::ftruncate(file_, static_cast<off_t>(size)) != 0) fail("cannot be repaired");
    ::lseek(file_, 0, SEEK_END);
  }

 private:
  [[noreturn]] void fail(const char* what) {
    throw StorageError(fmt::format("{}: {}: {}", name_, what, why()));
  }

  const std::string name_;
  int file_;
};

void sync_folder(const fs::path& folder) {
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;
  ::fsync(opened);
  ::close(opened);
}

}  // namespace

class MatchLogWriter::State {
 public:
  explicit State(const fs::path& path) : path_(path), file_(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC) {
    if (deflateInit2(&zlib_, 6, Z_DEFLATED, kGzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
      throw StorageError(fmt::format("{}: not enough memory to compress it", path.string()));
    output_.resize(kOutputBytes);
    pack(log_header());
    flush();
    sync_folder(path.parent_path());
  }
  ~State() { deflateEnd(&zlib_); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void add(std::int64_t time_ns, std::int32_t type, std::span<const std::byte> bytes) {
    if (bytes.size() > kMaxMessageBytes) return;
    // End a member only when another one begins, so that none is empty.
    if (offset_ - place_.offset >= kMemberBytes) {
      deflate_all(Z_FINISH);
      deflateReset(&zlib_);
      place_ = {bytes_, offset_};
    }
    const std::uint64_t offset = offset_;
    pack(message_header({time_ns, type, static_cast<std::int32_t>(bytes.size())}));
    pack(bytes);
    message_.time_ns = time_ns;
    message_.type = type;
    message_.bytes.assign(bytes.begin(), bytes.end());
    maker_.add(message_, offset, place_);
  }

  void flush() {
    deflate_all(Z_SYNC_FLUSH);
    file_.sync();
    file_.check_name();
  }

  void finish() {
    deflate_all(Z_FINISH);
    file_.sync();
    try {
      MatchLogIndex index = maker_.take();
      sign_match_log_index(path_, index);
      write_match_log_index(path_, index);
    } catch (const StorageError& error) {
      log::warning("the log is complete, but has no index yet: {}", error.what());
    }
  }

  std::uint64_t bytes_ = 0;
  MatchLogIndexMaker maker_;

 private:
  void pack(std::span<const std::byte> bytes) {
    zlib_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));  // zlib only reads it
    zlib_.avail_in = static_cast<uInt>(bytes.size());
    deflate_all(Z_NO_FLUSH);
    offset_ += bytes.size();
  }

  void deflate_all(int flush) {
    do {
      zlib_.next_out = output_.data();
      zlib_.avail_out = static_cast<uInt>(output_.size());
      deflate(&zlib_, flush);
      const std::size_t count = output_.size() - zlib_.avail_out;
      file_.write({output_.data(), count});
      bytes_ += count;
    } while (zlib_.avail_out == 0);
  }

  const fs::path path_;
  OutputFile file_;
  z_stream zlib_{};
  std::vector<Bytef> output_;
  std::uint64_t offset_ = 0;  // unpacked bytes
  UnpackPlace place_;         // beginning of the current member
  LoggedMessage message_;
};

MatchLogWriter::MatchLogWriter(const fs::path& path) : state_(std::make_unique<State>(path)) {}

MatchLogWriter::~MatchLogWriter() = default;

void MatchLogWriter::add(std::int64_t time_ns, std::int32_t type, std::span<const std::byte> message) {
  state_->add(time_ns, type, message);
}

void MatchLogWriter::flush() {
  state_->flush();
}

void MatchLogWriter::finish() {
  state_->finish();
}

std::uint64_t MatchLogWriter::bytes() const {
  return state_->bytes_;
}

const MatchLogIndex& MatchLogWriter::index() const {
  return state_->maker_.index();
}

namespace {

/// Finds the ends of messages in a log that arrives in chunks, and validates the messages' headers.
class MessageEnds {
 public:
  /// False if the bytes so far are not a valid log.
  bool take(std::span<const Bytef> bytes) {
    for (; !bytes.empty() && is_good_; bytes = bytes.subspan(1)) {
      if (left_ > 0) {  // inside a message
        const std::size_t count = std::min<std::size_t>(left_, bytes.size());
        left_ -= count;
        bytes = bytes.subspan(count - 1);
        continue;
      }
      head_[head_bytes_++] = std::byte(bytes[0]);
      if (head_bytes_ == head_.size()) read_head();
    }
    return is_good_;
  }
  /// Whether the bytes so far end at the end of a message or of the file's header.
  bool is_end() const { return is_good_ && left_ == 0 && head_bytes_ == 0; }
  /// Number of logs that have begun.
  std::size_t logs() const { return logs_; }

 private:
  void read_head() {
    head_bytes_ = 0;
    const bool is_first = std::exchange(is_first_, false);
    if (head_ == log_header()) {  // also where another log follows
      ++logs_;
      return;
    }
    const MessageHeader header = read_message_header(head_);
    is_good_ = !is_first && header.size >= 0 && header.type >= 0 && is_log_time(header.time_ns) &&
               (header.size <= kMaxMessageBytes || header.type == LoggedMessage::kIndex);
    left_ = is_good_ ? static_cast<std::size_t>(header.size) : 0;
  }

  static_assert(kLogHeaderBytes == kMessageHeaderBytes);
  std::array<std::byte, kMessageHeaderBytes> head_{};
  std::size_t head_bytes_ = 0, left_ = 0, logs_ = 0;
  bool is_first_ = true, is_good_ = true;
};

/// The intact part of a packed log.
struct WholePart {
  std::uint64_t end = 0;  // file offset: everything before it is intact
  bool is_in_member = false;
  bool has_flushes = false;         // as MatchLogWriter's logs have from their beginning
  std::uint32_t sum = 0, size = 0;  // CRC-32 and length of the unpacked bytes of an incomplete last member
};

/// Reads a packed log, one deflate block at a time, to find its intact part.
class BlockReader {
 public:
  explicit BlockReader(const fs::path& path)
      : name_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0) throw StorageError(fmt::format("{}: cannot be read: {}", name_, why()));
    if (inflateInit2(&zlib_, kGzip) != Z_OK) {
      ::close(file_);
      throw StorageError(fmt::format("{}: not enough memory to unpack it", name_));
    }
  }
  ~BlockReader() {
    inflateEnd(&zlib_);
    ::close(file_);
  }
  BlockReader(const BlockReader&) = delete;
  BlockReader& operator=(const BlockReader&) = delete;

  /// Throws StorageError on a stop request, if the file cannot be read, and above kMaxUnpackedBytes.
  WholePart read(const std::stop_token& stop) {
    WholePart whole;
    std::uint64_t unpacked_bytes = 0;
    MessageEnds ends;
    WholePart now;  // has the sum and size of the current member so far
    while (fill()) {
      if (stop.stop_requested()) throw StorageError(fmt::format("{}: was not read to its end", name_));
      zlib_.next_out = output_.data();
      zlib_.avail_out = static_cast<uInt>(output_.size());
      const std::size_t logs = ends.logs();
      const int result = inflate(&zlib_, Z_BLOCK);
      const std::span<const Bytef> got(output_.data(), output_.size() - zlib_.avail_out);
      if ((result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) || !ends.take(got)) break;
      if (ends.logs() != logs) whole.has_flushes = false;
      now.sum = static_cast<std::uint32_t>(crc32(now.sum, got.data(), static_cast<uInt>(got.size())));
      now.size += static_cast<std::uint32_t>(got.size());
      unpacked_bytes += got.size();
      if (unpacked_bytes > kMaxUnpackedBytes)
        throw StorageError(
            fmt::format("{}: is larger than {} GiB when unpacked", name_, kMaxUnpackedBytes >> 30U));
      if (result == Z_STREAM_END) {
        inflateReset(&zlib_);
        now = {};
        if (ends.is_end()) whole = {.end = taken(), .has_flushes = whole.has_flushes};
        continue;
      }
      // A flush ends with an empty stored block, so that the next block is byte-aligned.
      constexpr int kAfterBlock = 128, kUnusedBits = 7;
      if ((zlib_.data_type & kAfterBlock) != 0 && (zlib_.data_type & kUnusedBits) == 0 && ends.is_end() &&
          is_flush())
        whole = {.end = taken(), .is_in_member = true, .has_flushes = true, .sum = now.sum, .size = now.size};
    }
    return whole;
  }

 private:
  bool fill() {
    if (zlib_.avail_in > 0) return true;
    ssize_t count;
    do count = ::pread(file_, input_.data(), input_.size(), static_cast<off_t>(input_end_));
    while (count < 0 && errno == EINTR);
    if (count < 0) throw StorageError(fmt::format("{}: cannot be read: {}", name_, why()));
    zlib_.next_in = input_.data();
    zlib_.avail_in = static_cast<uInt>(count);
    input_end_ += static_cast<std::uint64_t>(count);
    return count > 0;
  }

  std::uint64_t taken() const { return input_end_ - zlib_.avail_in; }

  bool is_flush() const {
    std::array<Bytef, 4> last{};
    constexpr std::array<Bytef, 4> kFlush{0, 0, 0xff, 0xff};
    const auto at = static_cast<off_t>(taken() - last.size());
    return ::pread(file_, last.data(), last.size(), at) == static_cast<ssize_t>(last.size()) &&
           last == kFlush;
  }

  const std::string name_;
  int file_;
  z_stream zlib_{};
  std::array<Bytef, 16 * 1024> input_{};
  std::array<Bytef, 64 * 1024> output_{};
  std::uint64_t input_end_ = 0;
};

}  // namespace

RepairedMatchLog repair_match_log(const fs::path& path, const std::stop_token& stop) {
  if (!fs::is_regular_file(path)) throw StorageError(fmt::format("{}: is not a file", path.string()));
  const WholePart whole = BlockReader(path).read(stop);
  const std::uint64_t size = fs::file_size(path);
  if (size > 0 && whole.end == size && !whole.is_in_member) return {};
  if (!whole.has_flushes) return {.was_whole = false, .is_other = true};
  OutputFile file(path, O_WRONLY | O_CLOEXEC);
  file.cut(whole.end);
  if (whole.is_in_member) {
    // End of a member: an empty final block, then CRC-32 and size of its unpacked bytes, little-endian.
    std::array<Bytef, 5 + 4 + 4> end{1, 0, 0, 0xff, 0xff};
    for (unsigned i = 0; i < 4; ++i) {
      end[5 + i] = static_cast<Bytef>(whole.sum >> 8 * i);
      end[9 + i] = static_cast<Bytef>(whole.size >> 8 * i);
    }
    file.write(end);
  }
  file.sync();
  return {.was_whole = false, .removed_bytes = size - whole.end};
}

}  // namespace sslv
