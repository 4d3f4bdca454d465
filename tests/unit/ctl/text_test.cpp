// SPDX-License-Identifier: Apache-2.0
// The daemon's answers as ssl-visionctl prints them for people.
#include "base/plain_text.h"
#include "ctl/client.h"
#include "ctl/colors.h"
#include "ctl/diagnostics_text.h"
#include "ctl/status_text.h"
#include "ctl/table.h"
#include "ctl/terminal_text.h"

#include <cmath>

#include <gmock/gmock.h>

namespace sslv::text_test {
namespace {

using testing::HasSubstr;

TEST(Table, ColumnsAreAlignedWhateverTheirLetters) {
  EXPECT_EQ(table_text({{"id", true}, {"name"}, {"state"}}, {{"0", "Süd", "running"}, {"12", "Nord 1", ""}}),
            "id  name    state\n"
            " 0  Süd     running\n"
            "12  Nord 1\n");
}

TEST(Margins, AreALineForEachLabelAndSurface) {
  EXPECT_EQ(margins_text(nullptr), "  margins: carpet and floor were not seen yet\n");
  EXPECT_EQ(margins_text(Json::array()), "");
  const auto margin = [](const char* label, const char* surface, const Json& brighter, const Json& darker) {
    return Json{{"label", label}, {"surface", surface}, {"brighter", brighter}, {"darker", darker}};
  };
  EXPECT_EQ(margins_text({margin("green", "carpet", 0.09, nullptr),
                          margin("pink", "carpet", nullptr, nullptr), margin("green", "floor", 0.5, 0.05)}),
            "  margins, to the carpet at least 30 % are wanted:\n"
            "    green      carpet becomes green at +9 %  THIN\n"
            "    pink       carpet never does\n"
            "    green      floor becomes green at +50 %, floor becomes green at \u22125 %\n");
}

TEST(Refusal, SaysWhoChangedWhatSince) {
  EXPECT_EQ(refusal_text("/api/settings", 422, R"({"error": "/site: 4 is not allowed"})"),
            "/site: 4 is not allowed");
  EXPECT_EQ(refusal_text("/api/x", 502, "<html>"), "/api/x: HTTP status 502");
  const Json stale =
      Json::parse(R"({"error": "the settings are at revision 3, but this edit was made on 1", "revision": 3,
    "changed_since": [
      {"revision": 3, "time": 2, "who": "192.168.1.5", "what": "", "changes": [
        {"op": "replace", "path": "/site", "before": "A", "after": "B"},
        {"op": "add", "path": "/ids/0", "after": 1}]},
      {"revision": 2, "time": 1, "who": "192.168.1.6", "what": "", "changes": []}]})");
  EXPECT_EQ(
      refusal_text("/api/settings", 409, stale.dump()),
      "the settings are at revision 3, but this edit was made on 1; 192.168.1.5 made revision 3: /site: "
      "\"A\" -> \"B\", /ids/0: nothing -> 1; 192.168.1.6 made revision 2");
}

TEST(TerminalText, IsPlainWhateverTheDaemonSays) {
  const Json bad = Json::parse(
      R"([{"severity": "bad", "title": "\u001b[2J\u0007\u009b\u007f \u202e", "fix": "a\\b\nGO", "\u001b": 1}])");
  const std::string text = answer_text(bad, false, alerts_text);
  EXPECT_EQ(text, "bad   \\u001b[2J\\u0007\\u009b\\u007f \\u202e\n      a\\b\\u000aGO\n");
  const std::string json = answer_text(bad, true, alerts_text);
  EXPECT_TRUE(is_plain_text(terminal_json(bad, -1)));
  EXPECT_EQ(Json::parse(json), bad) << "JSON stays what it is";
}

TEST(TerminalText, LeavesOrdinaryWordsAlone) {
  const Json good = Json::parse(R"([{"severity": "bad", "title": "Größe \"x\" \\ 日本", "fix": "2"}])");
  EXPECT_EQ(answer_text(good, false, alerts_text), alerts_text(good));
  EXPECT_EQ(answer_text(good, true, alerts_text), good.dump(2) + "\n");
}

TEST(Quantiles, RefuseInvalidHistograms) {
  EXPECT_FALSE(quantile_us(Json::parse(R"({"edges_us": [0, 1, 2], "counts": [5, -1]})"), 2));
}

TEST(PathPart, EscapesWhatMeansSomethingElseInAnAddress) {
  EXPECT_EQ(path_part("Hall 3/ü?#%_-.~"), "Hall%203%2F%C3%BC%3F%23%25_-.~");
}

TEST(AlertsText, TheWorstFirst) {
  const Json alerts = Json::parse(R"([
    {"severity": "info", "title": "i", "fix": "1", "camera": null},
    {"severity": "warn", "title": "w", "fix": "2", "camera": 0},
    {"severity": "bad", "title": "b", "fix": "3", "camera": 0},
    {"severity": "warn", "title": "v", "fix": "4", "camera": 1}])");
  const Json sorted = worst_first(alerts);
  EXPECT_EQ(alerts_text(sorted), "bad   b\n      3\nwarn  w\n      2\nwarn  v\n      4\ninfo  i\n      1\n");
  EXPECT_TRUE(any_bad(alerts));
  EXPECT_FALSE(any_bad(Json::array({alerts[0], alerts[1]})));
  EXPECT_EQ(alerts_text(Json::array()), "no alerts\n");
}

TEST(ChecksText, BeginWithGoOrNoGo) {
  const Json checks = Json::parse(R"({"go": false, "checks": [
    {"id": "cameras", "title": "Cameras", "state": "fail", "value": "1 of 2", "unit": "", "text": "camera 0 is lost"},
    {"id": "latency", "title": "Latency", "state": "pass", "value": "4.1", "unit": "ms", "text": "p99, limit 5 ms"},
    {"id": "clock", "title": "Clock", "state": "pass", "value": "–", "unit": "", "text": "synchronised"}]})");
  EXPECT_EQ(checks_text(checks),
            "NO-GO\n"
            "state  check    figure  what was found\n"
            "fail   Cameras  1 of 2  camera 0 is lost\n"
            "pass   Latency  4.1 ms  p99, limit 5 ms\n"
            "pass   Clock            synchronised\n");
}

TEST(Quantile, LiesWithinItsBin) {
  const Json histogram = Json::parse(R"({"edges_us": [100, 200, 400, 800], "counts": [50, 0, 50]})");
  EXPECT_DOUBLE_EQ(*quantile_us(histogram, 0.5), 200);
  EXPECT_NEAR(*quantile_us(histogram, 0.25), 100 * std::sqrt(2), 1e-9);
  EXPECT_NEAR(*quantile_us(histogram, 0.75), 400 * std::sqrt(2), 1e-9);
  EXPECT_DOUBLE_EQ(*quantile_us(histogram, 1), 800);
  EXPECT_FALSE(quantile_us(Json::parse(R"({"edges_us": [], "counts": []})"), 0.5));
}

TEST(Diagnostics, SayWhatTakesHowLong) {
  const Json diagnostics = Json::parse(R"({
    "system": {"host": "vision", "kernel": "6.1", "uptime_s": 60, "load": [1, 0.5, 0.25], "cpu_percent": [10, 90],
               "memory": {"total_bytes": 8000000000, "available_bytes": 4000000000}, "disk": null,
               "temperature_c": null,
               "process": {"cpu_percent": 50, "rss_bytes": 100000000, "threads": 9, "descriptors": 30}},
    "clock": {"synchronised": false, "offset_ms": 1.5, "estimated_error_ms": 16},
    "cameras": [{"id": 0, "exposure": null, "latency": {"edges_us": [1000, 1000.001], "counts": [7]},
                 "age": {"edges_us": [], "counts": []},
                 "stages": [{"name": "segment", "histogram": {"edges_us": [200, 200.001], "counts": [7]}}]}]})");
  const std::string text = diagnostics_text(diagnostics);
  EXPECT_THAT(text, HasSubstr("memory    4.0 of 8.0 GB available\n"));
  EXPECT_THAT(text, HasSubstr("service   50 % of a core, 100 MB, 9 threads, 30 descriptors\n"));
  EXPECT_THAT(text, HasSubstr("clock     NOT synchronised, 1.500 ms off, accurate to 16.000 ms\n"));
  EXPECT_THAT(text, HasSubstr("camera  what     p50 ms  p99 ms\n"
                              "     0  segment   0.200   0.200\n"
                              "     0  latency   1.000   1.000\n"
                              "     0  age           -       -\n"));
}

TEST(StatusText, SaysWhatStagesHaveToSayBesidesWarnings) {
  const auto stage = [](const char* name, const char* library, const Json& note) {
    return Json{{"name", name}, {"library", library}, {"note", note}};
  };
  const Json status{
      {"site", "s"},
      {"version", "1"},
      {"uptime_s", 1},
      {"network", {{"group", "g"}, {"port", 1}, {"interface", ""}, {"packets_per_s", 0}, {"send_errors", 0}}},
      {"panel", {{"addresses", Json::array()}}},
      {"cameras",
       {{{"id", 4},
         {"name", "c"},
         {"state", "running"},
         {"width", 1},
         {"height", 1},
         {"fps", 1},
         {"latency_ms", {{"p50", 1}, {"p99", 1}}},
         {"frames", 1},
         {"robots", 0},
         {"balls", 0},
         {"stages",
          {stage("segment", "", nullptr),
           stage("find_tags", "april_tags.so", {{"kind", "note"}, {"text", "12 tags"}}),
           stage("loud", "", {{"kind", "warning"}, {"text", "dark"}})}}}}},
      {"tracks", {{"stages", {stage("look_ahead", "", {{"kind", "note"}, {"text", "80 ms"}})}}}},
      {"alerts", Json::array()}};
  const std::string text = status_text(status);
  EXPECT_THAT(text, testing::EndsWith("camera 4, find_tags from april_tags.so: 12 tags\n"
                                      "field, look_ahead: 80 ms\n"));
}

}  // namespace
}  // namespace sslv::text_test
