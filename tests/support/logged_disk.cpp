// SPDX-License-Identifier: Apache-2.0
// A disk that logs its requests in order: logged_disk FOLDER BYTES LOG mounts a file system at FOLDER with
// one file, `disk`, of BYTES zeros, for a loop device. LOG receives all writes and flushes (after which
// earlier writes must be durable), so that the disk's contents after a power cut at any time can be
// reconstructed. Records, little-endian: u8 'W' or 'F', f64 Unix time in s, u64 position, u32 number of
// bytes, and these bytes.
#define FUSE_USE_VERSION 35

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include <fuse3/fuse.h>

namespace {

std::vector<char> disk;
std::FILE* log_file = nullptr;

void note(char kind, std::uint64_t place, const char* bytes, std::uint32_t count) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const double time_s = static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
  std::fwrite(&kind, 1, 1, log_file);
  std::fwrite(&time_s, sizeof time_s, 1, log_file);
  std::fwrite(&place, sizeof place, 1, log_file);
  std::fwrite(&count, sizeof count, 1, log_file);
  if (count > 0) std::fwrite(bytes, 1, count, log_file);
  std::fflush(log_file);
}

bool is_disk(const char* path) {
  return std::strcmp(path, "/disk") == 0;
}

int get_attributes(const char* path, struct stat* out, fuse_file_info*) {
  *out = {};
  out->st_nlink = 1;
  out->st_mode = is_disk(path) ? S_IFREG | 0600 : S_IFDIR | 0700;
  if (is_disk(path)) out->st_size = static_cast<off_t>(disk.size());
  return is_disk(path) || std::strcmp(path, "/") == 0 ? 0 : -ENOENT;
}

int open_disk(const char* path, fuse_file_info*) {
  return is_disk(path) ? 0 : -ENOENT;
}

int read_disk(const char*, char* out, std::size_t count, off_t place, fuse_file_info*) {
  const auto from = static_cast<std::size_t>(place);
  if (from >= disk.size()) return 0;
  const std::size_t there = std::min(count, disk.size() - from);
  std::memcpy(out, disk.data() + from, there);
  return static_cast<int>(there);
}

int write_disk(const char*, const char* bytes, std::size_t count, off_t place, fuse_file_info*) {
  const auto to = static_cast<std::size_t>(place);
  if (to + count > disk.size()) return -ENOSPC;
  std::memcpy(disk.data() + to, bytes, count);
  note('W', to, bytes, static_cast<std::uint32_t>(count));
  return static_cast<int>(count);
}

int flush_disk(const char*, int, fuse_file_info*) {
  note('F', 0, nullptr, 0);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("usage: logged_disk FOLDER BYTES LOG\n", stderr), 64;
  disk.resize(std::strtoull(argv[2], nullptr, 10));
  log_file = std::fopen(argv[3], "wb");
  if (log_file == nullptr) return std::perror(argv[3]), 1;
  fuse_operations operations{};
  operations.getattr = get_attributes;
  operations.open = open_disk;
  operations.read = read_disk;
  operations.write = write_disk;
  operations.fsync = flush_disk;
  // In the foreground, one request at a time.
  char foreground[] = "-f", single[] = "-s";
  char* words[] = {argv[0], foreground, single, argv[1], nullptr};
  return fuse_main(4, words, &operations, nullptr);
}
