// SPDX-License-Identifier: Apache-2.0
// Adds more parts than a frame has room for.
#include <array>
#include <string>
#include <utility>

#include <kit/stages.h>

namespace {
template <int kOne>
struct OneOfMany {
  static constexpr std::array kName{'p', static_cast<char>('a' + kOne / 10),
                                    static_cast<char>('a' + kOne % 10)};
  static constexpr std::string_view kPartName{kName.data(), kName.size()};
  int value = 0;
  void clear() { value = 0; }
};
template <int kOne>
struct MakeOne {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, OneOfMany<kOne>& part) noexcept { part.value = kOne; }
};
template <int... kAll>
sslv::StageRows make_all(std::integer_sequence<int, kAll...>) {
  return sslv::stage_rows(sslv::stage<MakeOne<kAll>>("make_" + std::to_string(kAll), "")...);
}
}  // namespace

SSLV_STAGES(make_all(std::make_integer_sequence<int, 60>()))
