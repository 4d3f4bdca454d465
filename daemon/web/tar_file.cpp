// SPDX-License-Identifier: Apache-2.0
#include "web/tar_file.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <archive.h>
#include <archive_entry.h>

namespace sslv {

namespace {

constexpr std::size_t kBytesPerCheck = 256 * 1024;  // bytes compressed between two checks for a stop request

void refuse_when_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw std::runtime_error("the service ends");
}

/// Appends an archive to `bytes`.
class TarWriter {
 public:
  TarWriter(std::string& bytes, std::time_t modified) : bytes_(bytes), modified_(modified) {
    if (!out_ || !header_) throw std::bad_alloc();
  }

  archive* get() { return out_.get(); }

  void check(la_ssize_t result) {
    if (result < ARCHIVE_OK) throw std::runtime_error(archive_error_string(out_.get()));
  }
  void open() {
    check(archive_write_open(
        out_.get(), this, nullptr,
        [](archive*, void* to, const void* from, std::size_t size) -> la_ssize_t {
          auto& writer = *static_cast<TarWriter*>(to);
          if (writer.is_over_) return -1;
          writer.bytes_.append(static_cast<const char*>(from), size);
          return static_cast<la_ssize_t>(size);
        },
        nullptr));
  }
  void begin(const std::string& name, std::uint64_t size) {
    archive_entry_clear(header_.get());
    archive_entry_set_pathname(header_.get(), name.c_str());
    archive_entry_set_size(header_.get(), static_cast<la_int64_t>(size));
    archive_entry_set_filetype(header_.get(), AE_IFREG);
    archive_entry_set_perm(header_.get(), 0644);
    archive_entry_set_mtime(header_.get(), modified_, 0);
    check(archive_write_header(out_.get(), header_.get()));
  }
  void add(const std::vector<TarEntry>& entries, const std::stop_token& stop = {}) {
    for (const TarEntry& entry : entries) {
      begin(entry.name, entry.content.size());
      for (std::string_view left = entry.content; !left.empty();) {
        refuse_when_stopped(stop);
        const std::string_view piece = left.substr(0, kBytesPerCheck);
        check(archive_write_data(out_.get(), piece.data(), piece.size()));
        left.remove_prefix(piece.size());
      }
    }
  }
  void close() { check(archive_write_close(out_.get())); }
  /// Leaves the archive unfinished. (archive_write_fail() would leak memory.)
  void leave() {
    is_over_ = true;
    archive_write_close(out_.get());
  }

 private:
  std::string& bytes_;
  const std::time_t modified_;
  bool is_over_ = false;
  const std::unique_ptr<archive, decltype(&archive_write_free)> out_{archive_write_new(), archive_write_free};
  const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> header_{archive_entry_new(),
                                                                              archive_entry_free};
};

}  // namespace

std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified, const std::stop_token& stop) {
  std::string bytes;
  TarWriter out(bytes, modified);
  out.check(archive_write_add_filter_gzip(out.get()));
  out.check(archive_write_set_format_ustar(out.get()));
  out.check(archive_write_set_bytes_in_last_block(out.get(), 1));  // no zeros after the gzip data
  out.open();
  out.add(entries, stop);
  out.close();
  return bytes;
}

TarAround tar_around(const std::vector<TarEntry>& entries, const std::string& name, std::uint64_t size,
                     std::time_t modified) {
  constexpr std::size_t kRecord = 512;
  TarAround around;
  TarWriter out(around.before, modified);
  // ustar, except for what it cannot store: names above 100 bytes, files above 8 GiB.
  out.check(archive_write_set_format_pax_restricted(out.get()));
  out.check(archive_write_set_bytes_per_block(out.get(), 0));  // unbuffered: `before` is complete at once
  out.open();
  out.add(entries);
  out.begin(name, size);
  out.leave();
  around.after.assign((kRecord - size % kRecord) % kRecord + 2 * kRecord, '\0');
  return around;
}

namespace {

using Reader = std::unique_ptr<archive, decltype(&archive_read_free)>;

constexpr const char* kSparse = "it contains a sparse file";

Reader reader_of(std::string_view bytes, int (*support_filter)(archive*), int (*support_format)(archive*)) {
  Reader in(archive_read_new(), archive_read_free);
  if (!in) throw std::bad_alloc();
  if (support_filter(in.get()) != ARCHIVE_OK || support_format(in.get()) != ARCHIVE_OK ||
      archive_read_open_memory(in.get(), bytes.data(), bytes.size()) != ARCHIVE_OK)
    throw std::runtime_error("it cannot be read");
  return in;
}

[[noreturn]] void refuse_archive(const Reader& in) {
  const char* reason = archive_error_string(in.get());
  throw std::runtime_error(reason != nullptr ? reason : "its end is missing");
}

/// False at the end of the archive.
bool has_next(const Reader& in, archive_entry*& header) {
  const int result = archive_read_next_header(in.get(), &header);
  if (result != ARCHIVE_OK && result != ARCHIVE_EOF) refuse_archive(in);
  return result == ARCHIVE_OK;
}

/// Passes the current file's bytes to `use` in chunks. Throws std::runtime_error, also for a file with holes:
/// libarchive would expand the holes to zeros, and a few bytes in an archive can declare any number of zeros.
template <class Use>
void read_pieces(const Reader& in, const std::stop_token& stop, const Use& use) {
  for (std::uint64_t size = 0;;) {
    refuse_when_stopped(stop);
    const void* piece = nullptr;
    std::size_t bytes = 0;
    la_int64_t offset = 0;
    const int result = archive_read_data_block(in.get(), &piece, &bytes, &offset);
    if (result == ARCHIVE_EOF) return;
    if (result != ARCHIVE_OK) refuse_archive(in);
    if (static_cast<std::uint64_t>(offset) != size) throw std::runtime_error(kSparse);
    size += bytes;
    use(std::string_view(static_cast<const char*>(piece), bytes));
  }
}

/// Checks that all headers of an archive describe plain files; take() must receive all bytes of the archive
/// once. For other entries (sparse files, attributes that declare a file as sparse), libarchive builds
/// unlimited lists before its caller can examine the entry.
class HeaderCheck {
 public:
  void take(std::string_view bytes) {
    while (!bytes.empty() && !is_over_) {
      if (const std::size_t passed = std::min(content_bytes_, bytes.size()); passed > 0) {
        content_bytes_ -= passed;
        bytes.remove_prefix(passed);
        continue;
      }
      const std::size_t added = std::min(kRecord - header_.size(), bytes.size());
      header_ += bytes.substr(0, added);
      bytes.remove_prefix(added);
      if (header_.size() < kRecord) return;
      check();
      header_.clear();
    }
  }

 private:
  static constexpr std::size_t kRecord = 512, kSizeAt = 124, kSizeDigits = 12, kTypeAt = 156;

  void check() {
    is_over_ = header_.find_first_not_of('\0') == std::string::npos;
    if (is_over_) return;  // libarchive does not read what follows
    if (header_[kTypeAt] != '0' && header_[kTypeAt] != '\0')
      throw std::runtime_error(
          "it contains something that is not a plain file (`tar --format=ustar` packs only plain files)");
    // Accepts only sizes that libarchive reads as the same number. Otherwise libarchive would find the next
    // header at another place.
    std::string_view digits = std::string_view(header_).substr(kSizeAt, kSizeDigits);
    digits.remove_prefix(std::min(digits.find_first_not_of(' '), digits.size()));
    digits = digits.substr(0, digits.find_last_not_of(std::string_view(" \0", 2)) + 1);
    std::uint64_t size = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), size, 8);
    if (error != std::errc() || end != digits.data() + digits.size())
      throw std::runtime_error("it contains a file whose size is not an octal number");
    content_bytes_ = (size + kRecord - 1) / kRecord * kRecord;
  }

  std::string header_;
  std::size_t content_bytes_ = 0;  // bytes left before the next header
  bool is_over_ = false;
};

/// Checks all compressed bytes, including bytes after the end of the archive, which read_tar_gz() would skip.
void check_gz(std::string_view bytes, std::size_t max_bytes, const std::stop_token& stop) {
  const Reader in = reader_of(bytes, archive_read_support_filter_gzip, archive_read_support_format_raw);
  archive_entry* header = nullptr;
  if (!has_next(in, header)) throw std::runtime_error("it is empty");
  if (archive_filter_code(in.get(), 0) != ARCHIVE_FILTER_GZIP)
    throw std::runtime_error("it is not a .tar.gz file");
  std::size_t size = 0;
  HeaderCheck headers;
  read_pieces(in, stop, [&](std::string_view piece) {
    headers.take(piece);
    size += piece.size();
    if (size > max_bytes)
      throw std::runtime_error("unpacked, it is larger than " + std::to_string(max_bytes >> 20U) + " MiB");
  });
}

}  // namespace

std::vector<TarEntry> read_tar_gz(std::string_view bytes, std::size_t max_bytes,
                                  const std::stop_token& stop) {
  constexpr std::size_t kMaxEntries = 10'000;  // each takes memory besides its bytes
  check_gz(bytes, max_bytes, stop);
  const Reader in = reader_of(bytes, archive_read_support_filter_gzip, archive_read_support_format_tar);
  std::vector<TarEntry> entries;
  for (archive_entry* header = nullptr; has_next(in, header);) {
    const char* name = archive_entry_pathname(header);
    if (name == nullptr || archive_entry_filetype(header) != AE_IFREG || entries.size() == kMaxEntries)
      throw std::runtime_error("it contains something that is not a file");
    // The unpacked archive fits into `max_bytes`, so a file that declares more is incomplete.
    const auto size = static_cast<std::uint64_t>(archive_entry_size(header));
    if (size > max_bytes) throw std::runtime_error(kSparse);
    TarEntry& entry = entries.emplace_back(TarEntry{name, {}});
    entry.content.reserve(static_cast<std::size_t>(size));
    read_pieces(in, stop, [&](std::string_view piece) { entry.content += piece; });
    if (entry.content.size() != size) throw std::runtime_error(kSparse);
  }
  return entries;
}

}  // namespace sslv
