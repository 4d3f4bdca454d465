// SPDX-License-Identifier: Apache-2.0
#include "kit/read_stamp.h"

#include "base/plain_text.h"

#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>
#include <system_error>
#include <vector>

#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

constexpr auto kThisProcessor =
#if defined __x86_64__
    EM_X86_64;
#elif defined __aarch64__
    EM_AARCH64;
#else
    EM_NONE;
#endif

std::string processor_name(unsigned machine) {
  switch (machine) {
    case EM_X86_64: return "x86-64";
    case EM_AARCH64: return "aarch64";
    case EM_386: return "32-bit x86";
    case EM_ARM: return "32-bit ARM";
    case EM_RISCV: return "RISC-V";
    default: return fmt::format("ELF machine type {}", machine);
  }
}

/// Bounded reads of a file whose tables may be corrupt.
class ElfFile {
 public:
  /// Opens with O_NONBLOCK: a FIFO without a writer would block.
  explicit ElfFile(const std::filesystem::path& file)
      : file_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {
    if (file_ < 0)
      throw StageLibraryError(fmt::format("cannot be read: {}", std::generic_category().message(errno)));
    struct stat about {};
    if (::fstat(file_, &about) == 0 && S_ISREG(about.st_mode)) return;
    ::close(file_);
    throw StageLibraryError("is not a regular file");
  }
  ~ElfFile() { ::close(file_); }
  ElfFile(const ElfFile&) = delete;
  ElfFile& operator=(const ElfFile&) = delete;

  template <class T>
  T at(std::uint64_t offset) {
    T value;
    read(offset, &value, sizeof value);
    return value;
  }

  void read(std::uint64_t offset, void* to, std::size_t bytes) {
    auto* at = static_cast<char*>(to);
    while (bytes > 0 && offset <= std::uint64_t{std::numeric_limits<std::int32_t>::max()}) {
      const ssize_t count = ::pread(file_, at, bytes, static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) break;
      at += count;
      offset += static_cast<std::uint64_t>(count);
      bytes -= static_cast<std::size_t>(count);
    }
    if (bytes > 0) throw StageLibraryError("is truncated or not a shared object");
  }

 private:
  int file_;
};

template <std::size_t kSize>
std::string_view text_in(const std::array<char, kSize>& chars) {
  return {chars.data(), strnlen(chars.data(), chars.size())};
}

}  // namespace

StageStamp read_stamp(const std::filesystem::path& file) {
  ElfFile elf(file);
  std::array<unsigned char, EI_NIDENT> ident{};
  elf.read(0, ident.data(), SELFMAG);
  if (std::memcmp(ident.data(), ELFMAG, SELFMAG) != 0) throw StageLibraryError("is not a shared object");
  elf.read(0, ident.data(), ident.size());
  if (ident[EI_CLASS] != ELFCLASS64 || ident[EI_DATA] != ELFDATA2LSB) {
    throw StageLibraryError(fmt::format(
        "is made for a {}-bit processor with another byte order or word size; this program runs on {}",
        ident[EI_CLASS] == ELFCLASS64 ? 64 : 32, processor_name(kThisProcessor)));
  }
  const auto header = elf.at<Elf64_Ehdr>(0);
  if (header.e_machine != kThisProcessor) {
    throw StageLibraryError(fmt::format("is made for {}; this program runs on {}",
                                        processor_name(header.e_machine), processor_name(kThisProcessor)));
  }
  if (header.e_type != ET_DYN) throw StageLibraryError("is not a shared object");
  const auto section = [&](std::uint64_t index) {
    return elf.at<Elf64_Shdr>(header.e_shoff + index * sizeof(Elf64_Shdr));
  };
  constexpr std::string_view kNoStamp =
      "has no stamp of the stage kit: build it with the package ssl-visiond-stages-dev, and export its "
      "stages with SSLV_STAGES";
  if (header.e_shoff == 0 || header.e_shstrndx >= header.e_shnum)
    throw StageLibraryError(std::string(kNoStamp));
  const Elf64_Shdr names = section(header.e_shstrndx);
  for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
    const Elf64_Shdr one = section(i);
    std::array<char, kStampSection.size() + 1> name{};
    if (one.sh_type != SHT_PROGBITS || one.sh_name > names.sh_size ||
        names.sh_size - one.sh_name < name.size())
      continue;
    elf.read(names.sh_offset + one.sh_name, name.data(), name.size());
    if (name.back() != '\0' || text_in(name) != kStampSection) continue;
    StageStamp stamp;
    // The stamp of another version may be shorter or longer; its first fields are the same in all versions.
    std::vector<char> bytes(std::min<std::uint64_t>(one.sh_size, sizeof stamp));
    elf.read(one.sh_offset, bytes.data(), bytes.size());
    std::memcpy(static_cast<void*>(&stamp), bytes.data(), bytes.size());
    if (text_in(stamp.magic) != kStampMagic) throw StageLibraryError(std::string(kNoStamp));
    return stamp;
  }
  throw StageLibraryError(std::string(kNoStamp));
}

void check_stamp(const StageStamp& stamp) {
  static constexpr StageStamp kOurs = this_stamp();
  const std::string_view again = "rebuild it with this version's ssl-visiond-stages-dev";
  if (stamp.kit_version != kKitVersion) {
    throw StageLibraryError(
        fmt::format("is built for version {} of the stage kit, but this is version {}: {}", stamp.kit_version,
                    kKitVersion, again));
  }
  if (stamp.compiler != kOurs.compiler) {
    throw StageLibraryError(fmt::format("is built with {}, but this program with {}: {}",
                                        escaped_text(text_in(stamp.compiler)), kStampCompiler, again));
  }
  for (std::size_t i = 0; i < kOurs.types.size(); ++i) {
    const StampedType &theirs = stamp.types[i], &ours = kOurs.types[i];
    if (theirs == ours) continue;
    const std::string name = escaped_text(text_in(ours.size == 0 ? theirs.name : ours.name));
    if (theirs.size == ours.size && theirs.alignment != ours.alignment) {
      throw StageLibraryError(
          fmt::format("has a different alignment of {} ({} bytes) than this program ({} bytes): rebuild it "
                      "without options for one processor (-march=native)",
                      name, theirs.alignment, ours.alignment));
    }
    throw StageLibraryError(
        fmt::format("has a different layout of {} ({} bytes) than this program ({} bytes): {}", name,
                    theirs.size, ours.size, again));
  }
}

}  // namespace sslv
