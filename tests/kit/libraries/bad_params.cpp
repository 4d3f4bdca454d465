// SPDX-License-Identifier: Apache-2.0
// Stages with invalid parameters or names; SSLV_TEST_ROW selects one.
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include <kit/stages.h>

namespace {
using sslv::number;
constexpr double kEndless = std::numeric_limits<double>::infinity();

struct NanDefault {
  double a = std::nan("");
  static constexpr auto fields() { return std::tuple{number("a", &NanDefault::a, 0.0, 1.0, "", "")}; }
};
struct DefaultOutOfRange {
  double a = 2;
  static constexpr auto fields() { return std::tuple{number("a", &DefaultOutOfRange::a, 0.0, 1.0, "", "")}; }
};
struct EndlessRange {
  double a = 0.5;
  static constexpr auto fields() { return std::tuple{number("a", &EndlessRange::a, 0.0, kEndless, "", "")}; }
};
struct Twice {
  double a = 0.5, b = 0.5;
  static constexpr auto fields() {
    return std::tuple{number("a", &Twice::a, 0.0, 1.0, "", ""), number("a", &Twice::b, 0.0, 1.0, "", "")};
  }
};
struct None {
  static constexpr auto fields() { return std::tuple{}; }
};
struct BadName {
  static constexpr std::string_view kPartName = "Bad\nName";
  void clear() {}
};

template <class P>
struct Nothing {
  using Params = P;
  void process(const Params&, const sslv::BallList&) noexcept {}
};
struct BringsBadName {
  using Params = None;
  void process(const Params&, BadName&) noexcept {}
};

sslv::StageType row() {
  const char* const which = std::getenv("SSLV_TEST_ROW");
  const std::string name = which == nullptr ? "nan_default" : which;
  if (name == "default_out_of_range") return sslv::stage<Nothing<DefaultOutOfRange>>(name, "");
  if (name == "endless_range") return sslv::stage<Nothing<EndlessRange>>(name, "");
  if (name == "twice") return sslv::stage<Nothing<Twice>>(name, "");
  if (name == "long_help") return sslv::stage<Nothing<None>>(name, std::string(501, 'x'));
  if (name == "bad_part") return sslv::stage<BringsBadName>(name, "");
  return sslv::stage<Nothing<NanDefault>>(name, "");
}
}  // namespace

SSLV_STAGES(row())
