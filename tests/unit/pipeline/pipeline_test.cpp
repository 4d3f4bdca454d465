// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pipeline.h"

#include <gmock/gmock.h>

#include "pipeline/frame_ring.h"
#include "pipeline/publish.h"

namespace sslv {
namespace {

struct MakeLabels {
  struct Params {
    int level = 7;
    static constexpr auto fields() { return std::tuple{number("level", &Params::level, 0, 255, "", "grey level")}; }
  };
  void process(const Params& params, const Image&, LabelImage& out) noexcept { out.width = params.level; }
};
struct NeedRuns {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const RunList&, RegionList&) noexcept {}
};

const std::array kTable{stage<MakeLabels>("make_labels", ""), stage<NeedRuns>("need_runs", "")};

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Pipeline, NamesTheMissingPart) {
  EXPECT_EQ(error_of([] { Pipeline(kTable, {"make_labels", "need_runs"}, "/cameras/0/stack"); }),
            "/cameras/0/stack/1: stage 'need_runs' needs 'runs', which no earlier stage provides");
}

}  // namespace
}  // namespace sslv
