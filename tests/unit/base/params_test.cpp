// SPDX-License-Identifier: Apache-2.0
#include "base/params_json.h"

#include <functional>

#include <gmock/gmock.h>

namespace sslv::params_test {
namespace {

enum class Mode { kFast, kExact };

struct Point {
  int x = 1;
  std::optional<double> weight;
  static constexpr auto fields() {
    return std::tuple{number("x", &Point::x, -10, 10, "mm", "place"),
                      number("weight", &Point::weight, 0.0, 1.0, "", "null: equal")};
  }
};

struct Sample {
  int count = 3;
  double gain = 1.5;
  bool on = true;
  std::string title = "none";
  Mode mode = Mode::kFast;
  std::optional<Mode> backup;
  std::optional<int> limit;
  Point origin;
  std::optional<Point> extra;
  std::vector<Point> points;
  std::optional<std::vector<Point>> own_points;
  std::vector<std::string> stack{"a", "b"};
  std::array<int, 2> luma{10, 20};
  Json options = Json::object();

  static constexpr auto fields() {
    constexpr std::array kModes{Choice<Mode>{"fast", Mode::kFast}, Choice<Mode>{"exact", Mode::kExact}};
    return std::tuple{number("count", &Sample::count, 0, 100, "px", "how many"),
                      number("gain", &Sample::gain, 0.0, 16.0, "", "how bright"),
                      flag("on", &Sample::on, "whether"),
                      text("title", &Sample::title, "what"),
                      choice("mode", &Sample::mode, kModes, "how"),
                      choice("backup", &Sample::backup, kModes, "how else; null: not"),
                      number("limit", &Sample::limit, 1, 9, "", "null: none"),
                      group("origin", &Sample::origin, "where"),
                      group("extra", &Sample::extra, "where else"),
                      list("points", &Sample::points, "where all"),
                      list("own_points", &Sample::own_points, "null: as usual"),
                      names("stack", &Sample::stack, "in order"),
                      range("luma", &Sample::luma, 0, 255, "", "between"),
                      object("options", &Sample::options, "the backend's")};
  }
};

Sample read(const std::string& json) {
  return params_from_json<Sample>(Json::parse(json), "/camera");
}

std::string error_of(const std::string& json) {
  try {
    read(json);
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Params, AbsentKeysKeepTheirDefaults) {
  EXPECT_EQ(params_to_json(read("{}")), params_to_json(Sample{}));
  const Sample one = read(R"({"gain": 2})");
  EXPECT_EQ(one.gain, 2);
  EXPECT_EQ(one.count, 3);
  EXPECT_THAT(one.stack, testing::ElementsAre("a", "b"));
}

TEST(Params, EveryKindOfFieldSurvivesARoundTrip) {
  const Json full = Json::parse(R"({
    "count": 7, "gain": 0.25, "on": false, "title": "Größe", "mode": "exact", "backup": "fast", "limit": 9,
    "origin": {"x": -10, "weight": 0.5}, "extra": {"x": 2, "weight": null},
    "points": [{"x": 3, "weight": null}, {"x": 4, "weight": 1.0}],
    "own_points": [{"x": 5, "weight": 0.5}],
    "stack": ["c"], "luma": [0, 255], "options": {"serial": "A1", "depth": {"x": 1}}})");
  EXPECT_EQ(params_to_json(params_from_json<Sample>(full, "")), full);
}

TEST(Params, WritesKeysInTheOrderOfTheirDeclaration) {
  const std::string text = params_to_json(Point{}).dump();
  EXPECT_EQ(text, R"({"x":1,"weight":null})");
}

TEST(Params, NullMakesAnOptionalAbsent) {
  Sample sample;
  sample.limit = 5;
  sample.backup = Mode::kFast;
  sample.extra = Point{};
  read_params(sample, Json::parse(R"({"limit": null, "backup": null, "extra": null})"), "");
  EXPECT_EQ(sample.limit, std::nullopt);
  EXPECT_EQ(sample.backup, std::nullopt);
  EXPECT_FALSE(sample.extra.has_value());
}

TEST(Params, AListMayBeAbsentWhichIsNotEmpty) {
  EXPECT_FALSE(read("{}").own_points.has_value());
  const Sample none = read(R"({"own_points": []})");
  ASSERT_TRUE(none.own_points.has_value());
  EXPECT_TRUE(none.own_points->empty());
  EXPECT_EQ(params_to_json(none)["own_points"], Json::array());
  Sample some = read(R"({"own_points": [{"x": 5}]})");
  EXPECT_EQ(params_to_json(some)["own_points"][0]["x"], 5);
  read_params(some, Json{{"own_points", nullptr}}, "");
  EXPECT_EQ(params_to_json(some)["own_points"], nullptr);
  const Json schema = params_schema<Sample>()["properties"]["own_points"];
  EXPECT_EQ(schema["type"], Json::parse(R"(["array", "null"])"));
  EXPECT_EQ(schema["items"]["properties"]["x"]["maximum"], 10);
  EXPECT_EQ(schema["default"], nullptr);
}

TEST(Params, CommentsAreIgnoredInEveryObject) {
  const Sample sample = read(R"({"//": "why", "count": 5, "origin": {"//": ["any", "type"], "x": 2}})");
  EXPECT_EQ(sample.count, 5);
  EXPECT_EQ(sample.origin.x, 2);
}

TEST(Params, ControlCharactersAreRefusedAndEscaped) {
  EXPECT_EQ(error_of(R"({"title": "lo\u0000;id"})"),
            R"(/camera/title: "lo\u0000;id" is not allowed; expected a text without control characters and )"
            "without characters that change the direction of writing");
  EXPECT_THAT(error_of(R"({"stack": ["a", "b\u202e"]})"),
              testing::StartsWith(R"(/camera/stack/1: "b\u202e" is not allowed; expected a text without)"));
  EXPECT_EQ(error_of(R"({"count": "\u202e\u009b"})"),
            R"(/camera/count: "\u202e\u009b" is not allowed; expected a whole number 0 .. 100 px)");
  EXPECT_THAT(error_of(R"({"\u202e": 1})"), testing::StartsWith(R"(/camera/\u202e: no such parameter)"));
}

struct Secret {
  std::string word;
  static constexpr auto fields() { return std::tuple{secret("word", &Secret::word, "hidden")}; }
};

TEST(Params, SecretsMayBeAnyTextAndAreHidden) {
  EXPECT_EQ(params_from_json<Secret>(Json{{"word", "a\u202e\n"}}, "").word, "a\u202e\n");
  try {
    params_from_json<Secret>(Json{{"word", 12345678}}, "");
    FAIL();
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(), "/word: \"(hidden)\" is not allowed; expected a text");
  }
}

TEST(Params, UnknownKeysAreErrorsThatNameTheKnownOnes) {
  EXPECT_EQ(error_of(R"({"origin": {"y": 1}})"), "/camera/origin/y: no such parameter; known: x, weight");
  EXPECT_THAT(error_of(R"({"cuont": 1})"),
              testing::StartsWith("/camera/cuont: no such parameter; known: count, gain, on, title"));
}

struct Bad {
  const char* json;
  const char* error;
};

class RefusedValue : public testing::TestWithParam<Bad> {};

TEST_P(RefusedValue, NamesPathValueAndWhatIsAllowed) {
  EXPECT_EQ(error_of(GetParam().json), GetParam().error);
}

const Bad kBad[] = {
    {R"({"count": 101})", "/camera/count: 101 is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": -1})", "/camera/count: -1 is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": 3.5})", "/camera/count: 3.5 is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": 1e300})", "/camera/count: 1e+300 is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": 18446744073709551615})",
     "/camera/count: 18446744073709551615 is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": "3"})", "/camera/count: \"3\" is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": null})", "/camera/count: null is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"count": true})", "/camera/count: true is not allowed; expected a whole number 0 .. 100 px"},
    {R"({"gain": 16.001})", "/camera/gain: 16.001 is not allowed; expected a number 0.0 .. 16.0"},
    {R"({"gain": [1]})", "/camera/gain: [1] is not allowed; expected a number 0.0 .. 16.0"},
    {R"({"on": 1})", "/camera/on: 1 is not allowed; expected true or false"},
    {R"({"title": 1})", "/camera/title: 1 is not allowed; expected a text"},
    {R"({"mode": "slow"})", "/camera/mode: \"slow\" is not allowed; expected one of \"fast\" \"exact\""},
    {R"({"mode": 0})", "/camera/mode: 0 is not allowed; expected one of \"fast\" \"exact\""},
    {R"({"backup": "slow"})",
     "/camera/backup: \"slow\" is not allowed; expected null or one of \"fast\" \"exact\""},
    {R"({"limit": 0})", "/camera/limit: 0 is not allowed; expected a whole number 1 .. 9"},
    {R"({"origin": 1})", "/camera/origin: 1 is not allowed; expected an object"},
    {R"({"origin": null})", "/camera/origin: null is not allowed; expected an object"},
    {R"({"extra": {"x": 11}})", "/camera/extra/x: 11 is not allowed; expected a whole number -10 .. 10 mm"},
    {R"({"points": {}})", "/camera/points: {} is not allowed; expected a list"},
    {R"({"points": [{"x": 1}, {"x": 11}]})",
     "/camera/points/1/x: 11 is not allowed; expected a whole number -10 .. 10 mm"},
    {R"({"stack": "a"})", "/camera/stack: \"a\" is not allowed; expected a list of names"},
    {R"({"stack": ["a", 2]})", "/camera/stack/1: 2 is not allowed; expected a name"},
    {R"({"luma": [1]})", "/camera/luma: [1] is not allowed; expected [low, high]"},
    {R"({"luma": [1, 256]})", "/camera/luma/1: 256 is not allowed; expected a whole number 0 .. 255"},
    {R"({"luma": [2, 1]})", "/camera/luma: [2,1] is not allowed; expected [low, high] with low <= high"},
    {R"({"options": []})", "/camera/options: [] is not allowed; expected an object"},
    {"[]", "/camera: [] is not allowed; expected an object"},
};
INSTANTIATE_TEST_SUITE_P(Params, RefusedValue, testing::ValuesIn(kBad));

TEST(Params, WholeNumbersMayBeWrittenWithAPoint) {
  EXPECT_EQ(read(R"({"count": 3.0})").count, 3);
}

TEST(Params, TheRangeIsClosed) {
  EXPECT_EQ(read(R"({"count": 0})").count, 0);
  EXPECT_EQ(read(R"({"count": 100})").count, 100);
  EXPECT_EQ(read(R"({"gain": 16})").gain, 16);
}

// JSON text cannot contain them, but values built in memory can.
TEST(Params, NotANumberAndInfinityAreRefused) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Json json;
    json["gain"] = value;
    EXPECT_THROW(params_from_json<Sample>(json, ""), SettingsError);
    json = Json::object();
    json["count"] = value;
    EXPECT_THROW(params_from_json<Sample>(json, ""), SettingsError);
  }
}

TEST(Params, LongValuesAreCutBetweenCharacters) {
  for (std::size_t shift = 0; shift < 2; ++shift) {
    std::string umlauts(shift, 'x');
    for (int i = 0; i < 60; ++i) umlauts += "ö";
    Json json;
    json["on"] = umlauts;
    try {
      params_from_json<Sample>(json, "");
      FAIL() << "no error";
    } catch (const SettingsError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("ö... is not allowed"));
      EXPECT_NO_THROW(Json(error.what()).dump()) << "not UTF-8";
    }
  }
}

struct Bounded {
  std::string name, file_name;
  std::vector<Point> points;
  std::vector<std::string> stages;
  std::vector<int> ids;
  std::vector<std::array<double, 2>> corners;
  Json rest = Json::object();
  static constexpr auto fields() {
    using B = Bounded;
    return std::tuple{
        text("name", &B::name, "", 5),      sslv::file("file_name", &B::file_name, ""),
        list("points", &B::points, "", 2),  names("stages", &B::stages, "", 2),
        numbers("ids", &B::ids, 1, 16, ""), point_list("corners", &B::corners, 0, 3, 0, 9, "px", ""),
        object("rest", &B::rest, "", 20)};
  }
};

std::string bounded_error_of(const Json& json) {
  try {
    params_from_json<Bounded>(json, "");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Params, LengthsAreLimited) {
  EXPECT_EQ(bounded_error_of({{"name", "größe"},
                              {"file_name", std::string(4095, 'f')},
                              {"points", {Json::object(), Json::object()}},
                              {"stages", {std::string(200, 's'), "b"}},
                              {"corners", {{1, 2}, {3, 4}, {5, 6}}},
                              {"rest", {{"key", std::string(15, 'v')}}}}),
            "no error");
  EXPECT_EQ(bounded_error_of({{"name", "größer"}}),
            "/name: \"größer\" is not allowed; expected a text of at most 5 characters");
  EXPECT_EQ(
      bounded_error_of({{"name", std::string(900'000, 'n')}}),
      "/name: \"" + std::string(56, 'n') + "... is not allowed; expected a text of at most 5 characters");
  EXPECT_THAT(bounded_error_of({{"file_name", std::string(4096, 'f')}}),
              testing::EndsWith("fff... is not allowed; expected a text of at most 4095 characters"));
  EXPECT_EQ(bounded_error_of({{"points", Json(std::vector<Json>(20'000, Json::object()))}}),
            "/points: 20000 entries are not allowed; expected at most 2");
  EXPECT_EQ(bounded_error_of({{"stages", {"a", "b", "c"}}}),
            "/stages: 3 entries are not allowed; expected at most 2");
  EXPECT_THAT(bounded_error_of({{"stages", {std::string(201, 's')}}}),
              testing::EndsWith("sss... is not allowed; expected a name of at most 200 characters"));
  EXPECT_EQ(bounded_error_of({{"corners", Json(std::vector<Json>(60'000, {1, 2}))}}),
            "/corners: 60000 entries are not allowed; expected at most 3");
  EXPECT_EQ(bounded_error_of({{"rest", {{"key", std::string(90'000, 'v')}}}}),
            "/rest: the object is too large; expected at most 20 values and bytes of text in it");
  EXPECT_THAT(bounded_error_of({{std::string(90'000, 'k'), 1}}),
              testing::AllOf(
                  testing::StartsWith("/kkk"), testing::HasSubstr("k...: no such parameter"),
                  testing::ResultOf([](const std::string& text) { return text.size(); }, testing::Lt(200U))));
}

TEST(Params, SchemaHasTheLimitsOfLengths) {
  const Json schema = params_schema<Bounded>()["properties"];
  EXPECT_EQ(schema["name"]["maxLength"], 5);
  EXPECT_EQ(schema["file_name"]["maxLength"], 4095);
  EXPECT_EQ(schema["points"]["maxItems"], 2);
  EXPECT_EQ(schema["points"]["items"]["type"], "object");
  EXPECT_EQ(schema["stages"]["maxItems"], 2);
  EXPECT_EQ(schema["stages"]["items"]["maxLength"], 200);
  EXPECT_EQ(schema["ids"]["maxItems"], 16);
  EXPECT_EQ(schema["corners"]["maxItems"], 3);
  EXPECT_EQ(params_schema<Sample>()["properties"]["title"]["maxLength"], kMaxTextLength);
  EXPECT_EQ(params_schema<Sample>()["properties"]["points"]["maxItems"], kMaxListItems);
}

TEST(Errors, AreShortened) {
  EXPECT_EQ(shortened("short"), "short");
  EXPECT_EQ(shortened("0123456789", 10), "0123456789");
  EXPECT_EQ(shortened("0123456789x", 10), "0123456...");
  EXPECT_EQ(shortened("012345ö89xx", 10), "012345...") << "never inside a character";
  EXPECT_EQ(std::string(SettingsError(std::string(900'000, 'x')).what()).size(), SettingsError::kMaxBytes);
}

TEST(Params, SchemaSaysTypeRangeUnitDefaultAndHelp) {
  const Json schema = params_schema<Sample>();
  EXPECT_EQ(schema["type"], "object");
  EXPECT_EQ(schema["additionalProperties"], false);
  const Json& properties = schema["properties"];
  EXPECT_EQ(properties["count"],
            Json::parse(R"({"type": "integer", "minimum": 0, "maximum": 100, "x-unit": "px",
                                                 "description": "how many", "default": 3})"));
  EXPECT_EQ(properties["gain"], Json::parse(R"({"type": "number", "minimum": 0.0, "maximum": 16.0,
                                                "description": "how bright", "default": 1.5})"));
  EXPECT_EQ(properties["on"],
            Json::parse(R"({"type": "boolean", "description": "whether", "default": true})"));
  EXPECT_EQ(properties["title"],
            Json::parse(R"({"type": "string", "maxLength": 200, "description": "what", "default": "none"})"));
  EXPECT_EQ(properties["mode"], Json::parse(R"({"type": "string", "enum": ["fast", "exact"],
                                                "description": "how", "default": "fast"})"));
  EXPECT_EQ(properties["backup"], Json::parse(R"({"type": ["string", "null"], "enum": ["fast", "exact", null],
                            "description": "how else; null: not", "default": null})"));
  EXPECT_EQ(properties["limit"], Json::parse(R"({"type": ["integer", "null"], "minimum": 1, "maximum": 9,
                                                 "description": "null: none", "default": null})"));
  EXPECT_EQ(properties["origin"]["properties"]["x"]["default"], 1);
  EXPECT_EQ(properties["origin"]["default"], Json::parse(R"({"x": 1, "weight": null})"));
  EXPECT_EQ(properties["extra"]["type"], Json::parse(R"(["object", "null"])"));
  EXPECT_EQ(properties["points"]["items"], params_schema<Point>());
  EXPECT_EQ(properties["stack"]["items"], Json::parse(R"({"type": "string", "maxLength": 200})"));
  EXPECT_EQ(properties["luma"]["items"], Json::parse(R"({"type": "integer", "minimum": 0, "maximum": 255})"));
  EXPECT_EQ(properties["luma"]["minItems"], 2);
  EXPECT_EQ(properties["options"]["type"], "object");
}

}  // namespace
}  // namespace sslv::params_test
