// SPDX-License-Identifier: Apache-2.0
#include "colors/lut_file.h"

#include "base/base64.h"
#include "base/error.h"
#include "base/json.h"
#include "colors/table_edit.h"
#include "support/test_data.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace sslv::lut_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

std::vector<ImportedTable> import_text(const std::string& text,
                                       const LabelSet& labels = LabelSet::built_in()) {
  return import_tables(bytes_of(text), "a file", labels);
}

template <class Act>
std::string error_of(const Act& act) {
  try {
    act();
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}
std::string error_of_text(const std::string& text) {
  return error_of([&] { import_text(text); });
}

ColorTable painted(int bits, Label label) {
  ColorTable table(bits);
  apply_edit(table, PaintEdit{label, {100, 150, 180}, {40, 30, 20}});
  apply_edit(table, PaintEdit{label::kBlue, {200, 20, 20}, {40, 30, 20}});
  return table;
}

// ---- our own tables

TEST(TableFile, ReadsTablesOfOurs) {
  for (const int bits : {5, 7}) {
    const ColorTable table = painted(bits, label::kPink);
    const auto from_lut = import_tables(encode_lut(table), "robots.lut");
    ASSERT_EQ(from_lut.size(), 1u);
    EXPECT_TRUE(from_lut[0].table == table);
    EXPECT_EQ(from_lut[0].name, "robots.lut");
    const auto from_json = import_text(table_json_text(table));
    ASSERT_EQ(from_json.size(), 1u);
    EXPECT_TRUE(from_json[0].table == table);
  }
}

TEST(TableFile, LabelsInJsonAreFoundByName) {
  const LabelSet there({{20, "purple", "#8020c0"}}, ""), here({{11, "purple"}}, "");
  const std::string text = table_json_text(painted(5, 20), there);
  EXPECT_EQ(Json::parse(text)["labels"][2], Json({{"value", 20}, {"name", "purple"}, {"color", "#8020c0"}}));
  EXPECT_TRUE(import_text(text, here)[0].table == painted(5, 11));
  EXPECT_THAT(error_of_text(text), HasSubstr("a file: has the label \"purple\", which is not one of clear"));
  EXPECT_TRUE(import_text(table_json_text(painted(5, 20)))[0].table == painted(5, 20)) << "without a name";
}

TEST(TableFile, SaysWhatIsWrongWithJson) {
  const Json good = Json::parse(table_json_text(painted(5, label::kPink)));
  const auto with = [&](const char* key, const Json& value) {
    Json json = good;
    if (value.is_discarded()) {
      json.erase(key);
    } else {
      json[key] = value;
    }
    return error_of_text(json.dump());
  };
  const Json gone(Json::value_t::discarded);
  EXPECT_THAT(error_of_text(good.dump().substr(0, 100)), HasSubstr("a file: is not valid JSON"));
  EXPECT_THAT(with("format", "another"), HasSubstr("is JSON, but not a colour table"));
  EXPECT_THAT(with("version", 2), HasSubstr("is of version 2; this program reads 1"));
  EXPECT_THAT(with("bits", 9), HasSubstr("9 bits a channel; expected 5 .. 8"));
  EXPECT_THAT(with("bits", -1), HasSubstr("\"bits\" is not a whole number"));
  EXPECT_THAT(with("bits", gone), HasSubstr("has no \"bits\""));
  EXPECT_THAT(with("labels", Json::array()), HasSubstr("without its name"));
  EXPECT_THAT(with("labels", Json::parse(R"([{"value": 32, "name": "a"}])")),
              HasSubstr("\"value\" is not a whole number 0 .. 31"));
  EXPECT_THAT(with("labels", Json::parse("[3]")), HasSubstr("\"labels\" is not a list of"));
  EXPECT_THAT(with("runs", 3), HasSubstr("\"runs\" is not a text"));
  const std::string runs = good["runs"].get<std::string>();
  EXPECT_THAT(with("runs", runs.substr(0, runs.size() / 4 * 4 - 1)),
              HasSubstr("\"runs\" is not complete base64"));
  EXPECT_THAT(with("runs", runs.substr(0, runs.size() / 8 * 4)), HasSubstr("it is cut off"));
}

TEST(TableFile, ANoisyTableMayTakeMoreThanOtherJson) {
  ColorTable table(8);
  for (std::size_t i = 0; i < table.labels.size() / 2; i += 2) table.labels[i] = label::kPink;
  const std::string text = table_json_text(table);
  EXPECT_GT(text.size(), kMaxJsonBytes);
  EXPECT_TRUE(import_text(text)[0].table == table);
}

TEST(TableFile, JsonThatTakesMuchMemoryOrTimeIsRefused) {
  std::string lists = R"({"labels": [[])";
  while (lists.size() < 5'000'000) lists += ",[]";
  EXPECT_EQ(error_of_text(lists + "]}"), "a file: JSON that takes more than 64 MiB of memory");
  std::string keys = R"({"a": 1)";
  for (int i = 0; i < 1000; ++i) keys += fmt::format(R"(,"{}": 1)", i);
  EXPECT_EQ(error_of_text(keys + "}"), "a file: JSON with more than 1000 keys in an object");
  const std::string deep = std::string(100'000, '[');
  EXPECT_EQ(error_of_text(R"({"a": )" + deep), "a file: JSON nested deeper than 64 levels");
}

// ---- SSL-Vision's

/// A LUT with 4/6/6 bits of Y, U and V, padded like SSL-Vision's.
std::string blob(Label label, std::size_t size = 131'072) {
  Bytes bytes(size);
  for (std::size_t y = 4; y < 8; ++y) {
    for (std::size_t u = 30; u < 40; ++u) {
      for (std::size_t v = 50; v < 55; ++v) bytes[y << 12 | u << 6 | v] = label;
    }
  }
  return to_base64(bytes);
}

std::string var(const std::string& name, const std::string& type, const std::string& content) {
  return "<Var name=\"" + name + "\" type=\"" + type + "\">\n\t" + content + "\n</Var>\n";
}

std::string xml(const std::string& content) {
  return "\xEF\xBB\xBF<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<VarXML>\n" + content + "</VarXML>\n";
}

TEST(TableFile, SpreadsSslVisionsLutsToSevenBits) {
  for (const std::size_t size : {65'536u, 131'072u}) {
    const auto found = import_text(xml(var("LUT Data", "blob", blob(label::kPink, size))));
    ASSERT_EQ(found.size(), 1u);
    const ColorTable& table = found[0].table;
    EXPECT_EQ(table.bits, 7);
    for (int y = 0; y < 256; ++y) {
      for (int u = 0; u < 256; ++u) {
        for (const int v : {199, 200, 219, 220}) {
          const bool in = y / 16 >= 4 && y / 16 < 8 && u / 4 >= 30 && u / 4 < 40 && v / 4 >= 50 && v / 4 < 55;
          const Yuv c{static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(u),
                      static_cast<std::uint8_t>(v)};
          ASSERT_EQ(table.of(c), in ? label::kPink : label::kClear) << y << ' ' << u << ' ' << v;
        }
      }
    }
  }
}

TEST(TableFile, FindsTheLutsOfATreeWithTheirCameras) {
  const std::string text =
      xml(var("Global", "list", var("Speed", "double", "1,500000")) +
          var("Thread 0", "list", var("LUT 3D", "list", var("LUT Data", "blob", blob(label::kPink)))) +
          var("Thread 1", "list", var("LUT 3D", "list", var("LUT Data", "blob", blob(label::kBlue)))));
  const auto tables = import_text(text);
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[1].camera, 1);
  EXPECT_EQ(tables[1].name, "camera 1");
  EXPECT_EQ(tables[1].table.of({70, 130, 210}), label::kBlue);

  EXPECT_EQ(&choose_table(tables, std::nullopt, 1, "a file"), &tables[1]);
  EXPECT_EQ(&choose_table(tables, 0, std::nullopt, "a file"), &tables[0]);
  EXPECT_THAT(error_of([&] { choose_table(tables, std::nullopt, std::nullopt, "a file"); }),
              HasSubstr("a file: has several tables; choose one: 0: camera 0, 1: camera 1"));
  EXPECT_THAT(error_of([&] { choose_table(tables, std::nullopt, 4, "a file"); }),
              HasSubstr("has 0 tables for camera 4; it has 0: camera 0"));
  EXPECT_THAT(error_of([&] { choose_table(tables, 2, std::nullopt, "a file"); }),
              HasSubstr("has no table 2"));
}

TEST(TableFile, TheFilesNameTellsTheCamera) {
  const Bytes bytes = bytes_of(xml(var("LUT Data", "blob", blob(label::kPink))));
  const auto tables = import_tables(bytes, "robocup-ssl-cam-3-lut-yuv.xml");
  EXPECT_EQ(tables[0].camera, 3);
  EXPECT_EQ(&choose_table(tables, std::nullopt, std::nullopt, ""), &tables[0]);
  EXPECT_FALSE(import_tables(bytes, "lut.xml")[0].camera);
}

TEST(TableFile, EmptyTablesReplaceNothing) {
  const std::string empty = var("LUT Data", "blob", to_base64(Bytes(131'072)));
  const std::string why = "a file: is an empty colour table: no cell has a colour";
  EXPECT_EQ(error_of_text(xml(empty)), why);
  EXPECT_EQ(error_of_text(table_json_text(ColorTable(7))), why);
  EXPECT_EQ(error_of([] { import_tables(encode_lut(ColorTable(7)), "a file"); }), why);
  const auto tables = import_text(xml(var("Camera 0", "list", empty) +
                                      var("Camera 1", "list", var("LUT Data", "blob", blob(label::kPink)))));
  ASSERT_EQ(tables.size(), 2u) << "so that the user chooses";
  EXPECT_EQ(&choose_table(tables, std::nullopt, 1, "a file"), &tables[1]);
  EXPECT_EQ(error_of([&] { choose_table(tables, std::nullopt, 0, "a file"); }),
            "a file, camera 0: is an empty colour table: no cell has a colour");
}

TEST(TableFile, BearsMistakesInXml) {
  const std::string lut = var("LUT Data", "blob", blob(label::kPink));
  const auto found = [&](const std::string& text) { return import_text(text)[0].table.of({70, 130, 210}); };
  EXPECT_EQ(found(xml(var("a & b <c", "list", lut))), label::kPink) << "unescaped";
  EXPECT_EQ(found("<VarXML>" + lut), label::kPink) << "not closed";
  EXPECT_EQ(found("\n\n" + xml(lut).substr(3)), label::kPink) << "space in front";
  EXPECT_EQ(found(xml("<Var name=\"x\" type=\"double\" minval=>3</Var>" + lut)), label::kPink);
}

TEST(TableFile, SaysWhatIsWrongWithXml) {
  const auto of_blob = [](const std::string& text) {
    return error_of_text(xml(var("LUT Data", "blob", text)));
  };
  EXPECT_THAT(of_blob(to_base64(Bytes(1000))),
              HasSubstr("\"/LUT Data\" has 1000 bytes; a LUT of SSL-Vision"));
  EXPECT_THAT(of_blob(blob(label::kPink).substr(0, 30'001)),
              HasSubstr("is not complete base64: the file was cut off"));
  EXPECT_THAT(of_blob(blob(10)), HasSubstr("\"/LUT Data\" has label 10; SSL-Vision's labels are 0 .. 9"));
  EXPECT_THAT(of_blob(""), HasSubstr("has 0 bytes"));
  EXPECT_THAT(error_of_text(xml(var("Global", "list", ""))), HasSubstr("a file: is XML without a LUT"));
  EXPECT_THAT(error_of_text(xml("<Var name=\"LUT 3D\" type=\"external\" filename=\"cam-0-lut.xml\"></Var>")),
              HasSubstr("has no LUT; it refers to cam-0-lut.xml"));
  EXPECT_THAT(error_of_text("<"), HasSubstr("starts like XML, but is not valid XML"));
  EXPECT_THAT(error_of_text("hello"), HasSubstr("a file: is not a colour table: neither a .lut file"));
  EXPECT_THAT(error_of_text(""), HasSubstr("a file: is empty"));
}

TEST(TableFile, ExpandsNoEntities) {
  std::string text = "<!DOCTYPE VarXML [<!ENTITY a \"AAAA\">";
  for (char c = 'b'; c < 'k'; ++c) {
    text += std::string("<!ENTITY ") + c + " \"";
    for (int i = 0; i < 10; ++i) text += std::string("&") + static_cast<char>(c - 1) + ";";
    text += "\">";
  }
  text += "<!ENTITY file SYSTEM \"file:///etc/passwd\">]>";
  EXPECT_THAT(error_of_text(text + "<VarXML>" + var("LUT Data", "blob", "&j;") + "</VarXML>"),
              HasSubstr("has 0 bytes"));
  EXPECT_THAT(error_of_text(text + "<VarXML>" + var("LUT Data", "blob", "&file;") + "</VarXML>"),
              HasSubstr("has 0 bytes"));
}

TEST(TableFile, DepthIsBounded) {
  std::string text = "<VarXML>";
  for (int i = 0; i < 100'000; ++i) text += "<Var name=\"a\">";
  EXPECT_NE(error_of_text(text), "no error");
}

/// Real files of leagues and teams.
class RealFile : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_))
      GTEST_SKIP() << folder_ << " is not there: SSL-Vision's own files are not read";
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string error_of_file(const std::string& name) const {
    return error_of([&] { import_tables(bytes_of(read(name)), name); });
  }
  const std::filesystem::path folder_ = test_data_folder() / "configs";
};

TEST_F(RealFile, LutsHaveTheirLabelsInEveryCell) {
  for (const char* name : {"league_robocup-ssl-cam-0-lut-yuv.xml", "delft_robocup-ssl-cam-0-lut-yuv.xml"}) {
    const std::string text = read(name);
    const auto tables = import_tables(bytes_of(text), name);
    ASSERT_EQ(tables.size(), 1u) << name;
    EXPECT_EQ(tables[0].camera, 0);
    const std::size_t begin = text.find("\"blob\">") + 7;
    const auto bytes = from_base64(std::string_view(text).substr(begin, text.find('<', begin) - begin));
    ASSERT_TRUE(bytes);
    std::size_t labelled = 0;
    for (std::size_t i = 0; i < 65'536; ++i) {
      const Yuv c{static_cast<std::uint8_t>((i >> 12) * 16 + 5),
                  static_cast<std::uint8_t>((i >> 6 & 63) * 4 + 2),
                  static_cast<std::uint8_t>((i & 63) * 4 + 1)};
      ASSERT_EQ(tables[0].table.of(c), (*bytes)[i]) << name << ' ' << i;
      labelled += (*bytes)[i] != 0;
    }
    EXPECT_GT(labelled, 100u) << name;
  }
}

TEST_F(RealFile, TreesNameTheFilesThatHoldTheirLuts) {
  for (const char* name :
       {"league_robocup-ssl.xml", "robojackets_robocup-ssl.xml", "delft-comma-decimals_robocup-ssl.xml"}) {
    EXPECT_THAT(error_of_file(name),
                AllOf(HasSubstr(name), HasSubstr("it refers to robocup-ssl-cam-0-lut-yuv.xml")));
  }
  EXPECT_THAT(error_of_file("league_robocup-ssl-cam-0-mask.xml"), HasSubstr("is XML without a LUT"));
}

}  // namespace
}  // namespace sslv::lut_file_test
