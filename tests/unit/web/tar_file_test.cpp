// SPDX-License-Identifier: Apache-2.0
#include "web/tar_file.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <zlib.h>

namespace sslv::tar_file_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kPlenty = 1024 * 1024;
const std::vector<TarEntry> kFiles{
    {"a.txt", "one"}, {"folder/b.bin", std::string(100'000, '\0')}, {"empty", ""}};

std::string refusal(const std::string& bytes, std::size_t max_bytes = kPlenty) {
  try {
    read_tar_gz(bytes, max_bytes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

/// Gzips a tar, because the reader takes only compressed ones.
std::string packed(std::string tar) {
  std::string out(::compressBound(tar.size()) + 64, '\0');
  z_stream stream{};
  EXPECT_EQ(::deflateInit2(&stream, 1, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(tar.data());
  stream.avail_in = static_cast<uInt>(tar.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(::deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  return out;
}
/// Also reads long names, which our reader refuses.
std::vector<TarEntry> read_any_tar(const std::string& tar) {
  const std::unique_ptr<archive, decltype(&archive_read_free)> in(archive_read_new(), archive_read_free);
  EXPECT_EQ(archive_read_support_format_tar(in.get()), ARCHIVE_OK);
  EXPECT_EQ(archive_read_open_memory(in.get(), tar.data(), tar.size()), ARCHIVE_OK);
  std::vector<TarEntry> entries;
  for (archive_entry* header = nullptr; archive_read_next_header(in.get(), &header) == ARCHIVE_OK;) {
    std::string content(static_cast<std::size_t>(archive_entry_size(header)), '\0');
    EXPECT_EQ(archive_read_data(in.get(), content.data(), content.size()),
              static_cast<la_ssize_t>(content.size()));
    entries.push_back({archive_entry_pathname(header), content});
  }
  return entries;
}

/// A header block of a tar, for what libarchive does not write.
std::string record(const std::string& name, std::size_t size, char type, const std::string& at_386 = {}) {
  std::string head(512, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { head.replace(at, text.size(), text); };
  put(0, name);
  put(100, "0000644");
  put(124, fmt::format("{:011o}", size));
  put(136, "00000000000");
  head[156] = type;
  put(257, std::string("ustar  ", 8));  // GNU tar's
  put(386, at_386);
  put(148, "        ");
  unsigned sum = 0;
  for (const char byte : head) sum += static_cast<unsigned char>(byte);
  put(148, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  return head;
}
const std::string kEnd(1024, '\0');

TEST(TarFile, IsReadAsItWasWritten) {
  const auto read = read_tar_gz(tar_gz(kFiles, 1'700'000'000), kPlenty);
  ASSERT_EQ(read.size(), kFiles.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].name, kFiles[i].name);
    EXPECT_EQ(read[i].content, kFiles[i].content);
  }
}

TEST(TarFile, CanWrapAFileThatIsNotInMemory) {
  for (const std::string& content :
       {std::string(), std::string("x"), std::string(512, 'y'), std::string(100'001, 'z')}) {
    const std::string name = "folder/" + std::string(200, 'n');
    const TarAround around = tar_around(kFiles, name, content.size(), 1'700'000'000);
    const auto read = read_any_tar(around.before + content + around.after);
    ASSERT_EQ(read.size(), kFiles.size() + 1);
    EXPECT_EQ(read.front().content, kFiles.front().content);
    EXPECT_EQ(read.back().name, name);
    EXPECT_EQ(read.back().content, content);
  }
  // Larger than the old format's twelve digits can express.
  EXPECT_LT(tar_around(kFiles, "large", 1'000'000'000'000, 0).before.size(), 200'000U);
}

TEST(TarFile, EveryCutIsFound) {
  const std::string bytes = tar_gz(kFiles, 1'700'000'000);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(refusal(bytes.substr(0, size)), "none") << size;
}

TEST(TarFile, RefusesOtherFiles) {
  EXPECT_NE(refusal("no archive"), "none");
  EXPECT_NE(refusal(std::string(100'000, '\0')), "none");
}

TEST(TarFile, IsNotUnpackedBeyondItsLimit) {
  const std::string bytes = tar_gz({{"large", std::string(8 * kPlenty, 'x')}}, 0);
  EXPECT_LT(bytes.size(), kPlenty);
  EXPECT_EQ(refusal(bytes), "unpacked, it is larger than 1 MiB");
}

TEST(TarFile, TheLimitAppliesToAllFilesTogether) {
  std::vector<TarEntry> many;
  for (int i = 0; i < 5; ++i) many.push_back({"file" + std::to_string(i), std::string(kPlenty / 4, 'x')});
  EXPECT_EQ(refusal(tar_gz(many, 0)), "unpacked, it is larger than 1 MiB");
  many.resize(3);
  EXPECT_EQ(refusal(tar_gz(many, 0)), "none");
}

TEST(TarFile, HolesAreNotFilled) {
  // As GNU tar writes sparse files: offset and size of each piece, then the whole size.
  const auto piece = [](std::size_t at, std::size_t size) {
    return fmt::format("{:011o} {:011o} ", at, size);
  };
  const auto sparse = [&](const std::string& pieces, std::size_t held, std::size_t size) {
    std::string all = pieces;
    all.resize(97, '\0');  // room for four pieces
    return packed(record("sparse", held, 'S', all + fmt::format("{:011o}", size)) + std::string(held, 'x') +
                  std::string((512 - held % 512) % 512, '\0') + kEnd);
  };
  const std::size_t large = std::size_t{750} << 20U;
  const std::string is_not_plain =
      "it contains something that is not a plain file (`tar --format=ustar` packs only plain files)";
  for (const std::string& bytes : {sparse(piece(large, 0), 0, large), sparse("", 0, large),
                                   sparse(piece(0, 512) + piece(large, 0), 512, large),
                                   sparse(piece(1000, 512), 512, 1512), sparse(piece(0, 512), 512, 1000)}) {
    EXPECT_LT(bytes.size(), 300U);
    EXPECT_EQ(refusal(bytes), is_not_plain);
  }
  EXPECT_EQ(refusal(packed(record("whole", 5, '0') + "hello" + std::string(507, '\0') + kEnd)), "none");
  EXPECT_NE(refusal(packed(record("huge", large, '0') + kEnd)), "none");

  // Newer versions use attributes and write the map before the content; libarchive stores it as a list.
  std::string map = "100000\n";
  for (int i = 0; i < 100'000; ++i) map += "0\n0\n";
  map.resize((map.size() + 511) / 512 * 512, '\0');
  std::string attributes = "22 GNU.sparse.major=1\n22 GNU.sparse.minor=0\n28 GNU.sparse.realsize=1000\n";
  const std::string head = record("attributes", attributes.size(), 'x');
  attributes.resize(512, '\0');
  EXPECT_EQ(refusal(packed(head + attributes + record("sparse", map.size(), '0') + map + kEnd)),
            is_not_plain);
}

TEST(TarFile, HeadersAreWhereLibarchiveFindsThem) {
  const std::string body = "hello" + std::string(507, '\0');
  const auto with_size = [&](const std::string& digits) {
    std::string head = record("whole", 5, '0');
    head.replace(124, 12, digits);
    unsigned sum = 8 * ' ';
    for (std::size_t i = 0; i < head.size(); ++i)
      if (i < 148 || i >= 156) sum += static_cast<unsigned char>(head[i]);
    head.replace(148, 6, fmt::format("{:06o}", sum));
    return refusal(packed(head + body + kEnd));
  };
  EXPECT_EQ(with_size(std::string("00000000005\0", 12)), "none");
  EXPECT_EQ(with_size("          5 "), "none");
  const std::string none = "it contains a file whose size is not an octal number";
  EXPECT_EQ(with_size("\x80" + std::string(10, '\0') + "\5"), none);
  EXPECT_EQ(with_size("-0000000005 "), none);
  EXPECT_EQ(with_size("5 0000000000"), none);
  EXPECT_EQ(with_size(std::string("5\0"
                                  "0000000000",
                                  12)),
            none);
  EXPECT_EQ(with_size(std::string(12, '\0')), none);
}

}  // namespace
}  // namespace sslv::tar_file_test
