// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// A place in a file at which reading can start.
struct UnpackPlace {
  std::uint64_t file_offset = 0;  // a gzip member begins there; equals `offset` if the file is not packed
  std::uint64_t offset = 0;       // unpacked bytes before the place

  bool operator==(const UnpackPlace&) const = default;
};

/// A place within a gzip member, at which inflating can resume with deflate's window.
struct MemberPlace {
  UnpackPlace place;  // file_offset: first byte that is not consumed at all
  int bits = 0;       // number of bits of the byte before it that are not consumed
  std::vector<unsigned char> window{};
};

/// Reads a file from its beginning or from a place; unpacks all members of a gzip file in order.
class PackedFile {
 public:
  /// Throws StorageError for a file that cannot be opened.
  explicit PackedFile(const std::filesystem::path& path);
  ~PackedFile();

  bool is_packed() const;

  /// Fills `out` and returns the number of bytes: fewer only if the file ends, or if the rest cannot be read;
  /// problem() then has the reason.
  std::size_t read(std::span<std::byte> out);

  /// Number of unpacked bytes before the first byte that the next read() returns.
  std::uint64_t offset() const;
  /// The last place at or before offset() at which reading can start.
  UnpackPlace place() const;
  /// The next read() starts at this place.
  void go_to(const UnpackPlace& place);
  void go_to(const MemberPlace& place);

  /// From now on, reading a packed file notes places within members, at least `every_bytes` unpacked bytes
  /// apart.
  void note_places(std::uint64_t every_bytes);
  /// Returns the places noted since the last call; all of them are at or before offset().
  std::vector<MemberPlace> take_places();

  /// problem() of a packed file that ends within a member.
  static constexpr const char* kCutOff = "is cut off";

  /// Why reading stopped before the file's end; empty if it did not.
  const std::string& problem() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace sslv
