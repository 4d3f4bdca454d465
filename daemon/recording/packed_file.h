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

/// A place of a packed file at which reading may begin.
struct UnpackPlace {
  std::uint64_t file_offset = 0;  // of a gzip member; of the byte itself where the file is not packed
  std::uint64_t offset = 0;       // of the first byte that comes of it

  bool operator==(const UnpackPlace&) const = default;
};

/// A place within a gzip member, at which reading can go on with what deflate remembers there.
struct MemberPlace {
  UnpackPlace place;  // file_offset: of the first byte that is not used up
  int bits = 0;       // of the byte before it that are not used up
  std::vector<unsigned char> window{};
};

/// Reads a file from its beginning or from a place; unpacks it where it is gzip, all members one after the
/// other.
class PackedFile {
 public:
  /// Throws StorageError for a file that cannot be opened.
  explicit PackedFile(const std::filesystem::path& path);
  ~PackedFile();

  bool is_packed() const;

  /// Fills `out`; fewer bytes only where the file ends, or cannot be read on: problem() says why then.
  std::size_t read(std::span<std::byte> out);

  /// Unpacked bytes before the next one that read() gives.
  std::uint64_t offset() const;
  /// The last place before it, or at it, at which reading may begin.
  UnpackPlace place() const;
  /// Goes on reading there.
  void go_to(const UnpackPlace& place);
  void go_to(const MemberPlace& place);

  /// From now on reading a packed file notes places within members, so many unpacked bytes apart or more.
  void note_places(std::uint64_t every_bytes);
  /// Those that were noted since it was asked last. None lies behind offset().
  std::vector<MemberPlace> take_places();

  /// problem() of a packed file that ends within a member.
  static constexpr const char* kCutOff = "is cut off";

  /// Why nothing more can be read before the file's end; empty when it ended as it should.
  const std::string& problem() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace sslv
