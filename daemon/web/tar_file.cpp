// SPDX-License-Identifier: Apache-2.0
#include "web/tar_file.h"

#include <memory>
#include <stdexcept>

#include <archive.h>
#include <archive_entry.h>

namespace sslv {

std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified) {
  std::string bytes;
  const std::unique_ptr<archive, decltype(&archive_write_free)> out(archive_write_new(), archive_write_free);
  const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> header(archive_entry_new(),
                                                                             archive_entry_free);
  if (!out || !header) throw std::bad_alloc();
  const auto check = [&](la_ssize_t result) {
    if (result < ARCHIVE_OK) throw std::runtime_error(archive_error_string(out.get()));
  };
  check(archive_write_add_filter_gzip(out.get()));
  check(archive_write_set_format_ustar(out.get()));
  check(archive_write_open(
      out.get(), &bytes, nullptr,
      [](archive*, void* to, const void* from, std::size_t size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(from), size);
        return static_cast<la_ssize_t>(size);
      },
      nullptr));
  for (const TarEntry& entry : entries) {
    archive_entry_clear(header.get());
    archive_entry_set_pathname(header.get(), entry.name.c_str());
    archive_entry_set_size(header.get(), static_cast<la_int64_t>(entry.content.size()));
    archive_entry_set_filetype(header.get(), AE_IFREG);
    archive_entry_set_perm(header.get(), 0644);
    archive_entry_set_mtime(header.get(), modified, 0);
    check(archive_write_header(out.get(), header.get()));
    check(archive_write_data(out.get(), entry.content.data(), entry.content.size()));
  }
  check(archive_write_close(out.get()));
  return bytes;
}

}  // namespace sslv
