// SPDX-License-Identifier: Apache-2.0
#include "recording/packed_file.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace sslv {
namespace {

constexpr std::size_t kInputBytes = 64 * 1024;
constexpr int kGzipOnly = 16 + MAX_WBITS, kRaw = -MAX_WBITS;
constexpr std::size_t kMemberEndBytes = 8;  // checksum and size

}  // namespace

class PackedFile::State {
 public:
  explicit State(const std::filesystem::path& path)
      : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    struct stat facts {};
    if (file_ < 0 || ::fstat(file_, &facts) != 0) {
      const int why = errno;
      close();
      throw StorageError(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(why)));
    }
    if (!S_ISREG(facts.st_mode)) {
      close();
      throw StorageError(fmt::format("{}: is not a file", path.string()));
    }
    std::array<unsigned char, 2> magic{};
    is_packed_ = ::pread(file_, magic.data(), magic.size(), 0) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
    if (is_packed_ && inflateInit2(&zlib_, kGzipOnly) != Z_OK) {
      close();
      throw StorageError(fmt::format("{}: not enough memory to unpack it", path.string()));
    }
  }
  ~State() {
    if (is_packed_) inflateEnd(&zlib_);
    close();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::size_t read(std::span<std::byte> out) {
    const std::size_t count = is_packed_ ? unpack(out) : copy(out);
    offset_ += count;
    return count;
  }

  void go_to(const UnpackPlace& place) {
    input_place_ = place.file_offset;
    input_.clear();
    zlib_.avail_in = 0;
    if (is_packed_) inflateReset2(&zlib_, kGzipOnly);
    is_raw_ = false;
    place_ = place;
    offset_ = noted_offset_ = place.offset;
    is_at_end_ = false;
    problem_.clear();
  }

  void go_to(const MemberPlace& within) {
    go_to(within.place);
    inflateReset2(&zlib_, kRaw);
    is_raw_ = true;
    unsigned char last = 0;
    if (within.bits > 0 && ::pread(file_, &last, 1, static_cast<off_t>(within.place.file_offset) - 1) == 1)
      inflatePrime(&zlib_, within.bits, last >> (8 - within.bits));
    inflateSetDictionary(&zlib_, within.window.data(), static_cast<uInt>(within.window.size()));
  }

  bool is_packed_ = false;
  std::uint64_t offset_ = 0;
  UnpackPlace place_;
  std::string problem_;
  std::uint64_t noted_every_ = 0;  // bytes; 0: no places are noted
  std::vector<MemberPlace> noted_;

 private:
  void close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }

  /// Reads bytes of the file without unpacking; 0 at its end, or after an error.
  std::size_t read_file(void* out, std::size_t size) {
    ssize_t count;
    do count = ::pread(file_, out, size, static_cast<off_t>(input_place_));
    while (count < 0 && errno == EINTR);
    if (count < 0) problem_ = fmt::format("cannot be read further: {}", std::strerror(errno));
    if (count <= 0) return 0;
    input_place_ += static_cast<std::uint64_t>(count);
    return static_cast<std::size_t>(count);
  }

  std::size_t copy(std::span<std::byte> out) {
    std::size_t done = 0;
    while (done < out.size()) {
      const std::size_t count = read_file(out.data() + done, out.size() - done);
      if (count == 0) break;
      done += count;
    }
    place_ = {offset_ + done, offset_ + done};
    return done;
  }

  bool fill() {
    if (zlib_.avail_in > 0) return true;
    input_.resize(kInputBytes);
    input_.resize(read_file(input_.data(), input_.size()));
    zlib_.next_in = input_.data();
    zlib_.avail_in = static_cast<uInt>(input_.size());
    return !input_.empty();
  }

  void skip(std::size_t count) {
    while (count > 0 && fill()) {
      const auto some = std::min<std::size_t>(count, zlib_.avail_in);
      zlib_.next_in += some;
      zlib_.avail_in -= static_cast<uInt>(some);
      count -= some;
    }
  }

  /// Notes a place if zlib is between two blocks of a member, far enough after the last noted place.
  void note_place(std::uint64_t offset) {
    constexpr int kAfterBlock = 128, kInLastBlock = 64, kUnusedBits = 7;
    if ((zlib_.data_type & kAfterBlock) == 0 || (zlib_.data_type & kInLastBlock) != 0 ||
        offset - noted_offset_ < noted_every_)
      return;
    MemberPlace here{.place = {taken(), offset}, .bits = zlib_.data_type & kUnusedBits};
    here.window.resize(std::size_t{1} << MAX_WBITS);
    uInt bytes = 0;
    inflateGetDictionary(&zlib_, here.window.data(), &bytes);
    here.window.resize(bytes);
    noted_.push_back(std::move(here));
    noted_offset_ = offset;
  }

  /// File offset of the next byte that zlib will consume.
  std::uint64_t taken() const { return input_place_ - zlib_.avail_in; }

  std::size_t unpack(std::span<std::byte> out) {
    zlib_.next_out = reinterpret_cast<Bytef*>(out.data());
    zlib_.avail_out = static_cast<uInt>(out.size());
    const auto done = [&] { return out.size() - zlib_.avail_out; };
    while (zlib_.avail_out > 0 && !is_at_end_) {
      if (!fill()) {
        is_at_end_ = true;
        // A file may end between two members.
        if (problem_.empty() && taken() != place_.file_offset) problem_ = kCutOff;
        break;
      }
      const int result = inflate(&zlib_, noted_every_ > 0 ? Z_BLOCK : Z_NO_FLUSH);
      if (result == Z_OK && noted_every_ > 0) note_place(offset_ + done());
      if (result == Z_STREAM_END) {
        if (is_raw_) skip(kMemberEndBytes);
        is_raw_ = false;
        inflateReset2(&zlib_, kGzipOnly);
        place_ = {taken(), offset_ + done()};
        // Ignore data after the last member (gzip pads with zeros on tapes).
        if (!fill() || *zlib_.next_in != 0x1f) is_at_end_ = true;
      } else if (result != Z_OK && result != Z_BUF_ERROR) {
        is_at_end_ = true;
        problem_ = "is damaged: its compressed data is invalid";
      }
    }
    return done();
  }

  int file_ = -1;
  z_stream zlib_{};
  std::vector<Bytef> input_;
  std::uint64_t input_place_ = 0;  // file offset just after input_
  bool is_at_end_ = false;
  bool is_raw_ = false;             // resumed within a member: zlib did not read the member's header
  std::uint64_t noted_offset_ = 0;  // unpacked bytes before the last noted place
};

PackedFile::PackedFile(const std::filesystem::path& path) : state_(std::make_unique<State>(path)) {}

PackedFile::~PackedFile() = default;

bool PackedFile::is_packed() const {
  return state_->is_packed_;
}

std::size_t PackedFile::read(std::span<std::byte> out) {
  return state_->read(out);
}

std::uint64_t PackedFile::offset() const {
  return state_->offset_;
}

UnpackPlace PackedFile::place() const {
  return state_->place_;
}

void PackedFile::go_to(const UnpackPlace& place) {
  state_->go_to(place);
}

void PackedFile::go_to(const MemberPlace& place) {
  state_->go_to(place);
}

void PackedFile::note_places(std::uint64_t every_bytes) {
  state_->noted_every_ = every_bytes;
}

std::vector<MemberPlace> PackedFile::take_places() {
  return std::exchange(state_->noted_, {});
}

const std::string& PackedFile::problem() const {
  return state_->problem_;
}

}  // namespace sslv
