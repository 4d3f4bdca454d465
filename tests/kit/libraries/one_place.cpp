// SPDX-License-Identifier: Apache-2.0
// Two parts with the same address, as if the loader had merged them.
#include <kit/stages.h>

namespace {
struct First {
  static constexpr std::string_view kPartName = "first_of_one_place";
  int value = 0;
  void clear() { value = 0; }
};
struct Second {
  static constexpr std::string_view kPartName = "second_of_one_place";
  double value = 0;
  void clear() { value = 0; }
};
template <class Part>
struct Make {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, Part& part) noexcept { part.value = 1; }
};

sslv::StageRows rows() {
  sslv::StageRows all = sslv::stage_rows(sslv::stage<Make<First>>("make_first", ""),
                                         sslv::stage<Make<Second>>("make_second", ""));
  all.camera[1].own_parts[0].place = all.camera[0].own_parts[0].place;
  return all;
}
}  // namespace

SSLV_STAGES(rows())
