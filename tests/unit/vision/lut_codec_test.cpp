// SPDX-License-Identifier: Apache-2.0
#include "vision/lut_codec.h"

#include "base/error.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>

namespace sslv::lut_codec_test {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

std::string error_of(const Bytes& bytes, const LabelSet& labels = LabelSet::built_in()) {
  try {
    decode_lut(bytes, "a.lut", labels);
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

/// A table with runs of all lengths.
ColorTable striped(int bits, Label labels) {
  ColorTable table(bits);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < table.labels.size();) {
    const std::size_t end = std::min(table.labels.size(), i + 1 + random() % (1U << random() % 18));
    const auto label = static_cast<Label>(random() % labels);
    for (; i < end; ++i) table.labels[i] = label;
  }
  return table;
}

TEST(LutCodec, GivesBackWhatItWasGiven) {
  for (const int bits : {5, 6, 7, 8}) {
    const ColorTable table = striped(bits, label::kCount);
    EXPECT_TRUE(decode_lut(encode_lut(table), "") == table) << bits;
    EXPECT_TRUE(decode_lut(encode_lut(ColorTable(bits)), "") == ColorTable(bits)) << bits;
  }
}

TEST(LutCodec, KeepsWhatPrintsLookLike) {
  ColorTable table = striped(6, label::kCount);
  table.prints[label::kGreen] = PrintColor{{2390, 5080, 2530}, 930};
  table.prints[label::kOrange] = PrintColor{{6040, 3100, 860}, 900};
  const Bytes bytes = encode_lut(table);
  EXPECT_TRUE(decode_lut(bytes, "") == table);
  EXPECT_TRUE(is_lut(bytes));
  for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 20)
    EXPECT_THAT(error_of(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length))),
                HasSubstr("a.lut: "));
  // The first share of green's print follows its label.
  const Bytes green{label::kGreen, 2390 & 0xFF, 2390 >> 8};
  Bytes wrong = bytes;
  const auto at = std::search(wrong.begin(), wrong.end(), green.begin(), green.end());
  ASSERT_NE(at, wrong.end());
  *(at + 2) = 200;
  EXPECT_THAT(error_of(wrong), HasSubstr("a.lut: has a print of label 7 whose shares do not add up to 1"));
}

TEST(LutCodec, IsCompact) {
  EXPECT_LT(encode_lut(ColorTable(8)).size(), 32u);
}

TEST(LutCodec, ReadsTheFirstVersion) {
  const ColorTable table = striped(7, label::kCount);
  Bytes bytes{'S', 'S', 'L', 'V', 'L', 'U', 'T', '1'};
  bytes.insert(bytes.end(), table.labels.begin(), table.labels.end());
  EXPECT_TRUE(decode_lut(bytes, "") == table);
  bytes[1000] = 17;
  EXPECT_THAT(error_of(bytes), HasSubstr("a.lut: has an unknown label 17; expected one of clear"));
  bytes.pop_back();
  EXPECT_THAT(error_of(bytes),
              HasSubstr("2097159 bytes; a .lut file that begins with \"SSLVLUT1\" has 2097160"));
}

TEST(LutCodec, LabelsAreFoundByName) {
  const LabelSet here({{20, "purple"}, {21, "lime"}}, ""), there({{10, "lime"}, {30, "purple"}}, "");
  ColorTable table(5);
  table.labels[5] = 20;
  table.labels[6] = 21;
  table.labels[7] = label::kPink;
  const ColorTable read = decode_lut(encode_lut(table, here), "", there);
  EXPECT_EQ(read.labels[5], 30);
  EXPECT_EQ(read.labels[6], 10);
  EXPECT_EQ(read.labels[7], label::kPink);
  EXPECT_THAT(error_of(encode_lut(table, here)),
              HasSubstr("has an unknown label \"purple\"; expected one of"));
}

TEST(LutCodec, ALabelWithoutANameKeepsItsValue) {
  ColorTable table(5);
  table.labels[5] = 20;
  EXPECT_TRUE(decode_lut(encode_lut(table), "") == table);
}

TEST(LutCodec, SaysWhatIsWrongWithAFile) {
  const Bytes good = encode_lut(striped(5, 3));
  const auto changed = [&](std::size_t at, std::uint8_t to) {
    Bytes bytes = good;
    bytes[at] = to;
    return bytes;
  };
  EXPECT_THAT(error_of(changed(0, 'X')),
              HasSubstr("a.lut: does not begin with \"SSLVLUT3\", \"SSLVLUT2\" or \"SSLVLUT1\""));
  EXPECT_THAT(error_of({}), HasSubstr("does not begin with"));
  EXPECT_THAT(error_of(changed(8, 4)), HasSubstr("4 bits a channel; expected 5 .. 8"));
  EXPECT_THAT(error_of(changed(10, 32)), HasSubstr("label 32; labels are 0 .. 31"));
  EXPECT_THAT(error_of(changed(12, 'C')), HasSubstr("has an unknown label \"Clear\""));
  for (const std::size_t size : {std::size_t{9}, std::size_t{11}, std::size_t{14}, good.size() - 1}) {
    EXPECT_THAT(error_of(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
                HasSubstr("it is cut off"))
        << size;
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_THAT(error_of(longer), HasSubstr("goes on after its last cell (bytes: 1)"));

  const Bytes head{'S', 'S', 'L', 'V', 'L', 'U', 'T', '2', 5, 1, 0, 5, 'c', 'l', 'e', 'a', 'r'};
  const auto with = [&](const Bytes& runs) {
    Bytes bytes = head;
    bytes.insert(bytes.end(), runs.begin(), runs.end());
    return bytes;
  };
  EXPECT_EQ(error_of(with({0, 0x80, 0x80, 2})), "no error");
  EXPECT_THAT(error_of(with({0, 0x81, 0x80, 2})), HasSubstr("a run at cell 0 that is longer than the table"));
  EXPECT_THAT(error_of(with({0, 0x80, 0x80, 0x80, 0x80, 0x80, 1})), HasSubstr("longer than the table"));
  EXPECT_THAT(error_of(with({0, 0})), HasSubstr("an empty run at cell 0"));
  EXPECT_THAT(error_of(with({3, 0x80, 0x80, 2})), HasSubstr("has label 3 without a name"));
  EXPECT_THAT(error_of(with({40, 1})), HasSubstr("label 40; labels are 0 .. 31"));
}

}  // namespace
}  // namespace sslv::lut_codec_test
