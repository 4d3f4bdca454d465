// SPDX-License-Identifier: Apache-2.0
// libFuzzer: any settings and any patch to them yield a complete tree or one SettingsError of one line, and
// an accepted tree is accepted again unchanged. A zero byte separates settings and patch. ./run test-long
#include "base/error.h"
#include "base/json.h"
#include "config/config.h"
#include "fuzz/expect.h"
#include "settings/history.h"
#include "settings/named_files.h"

#include <string>

namespace sslv {
namespace {

void check_refusal(const SettingsError& error) {
  const std::string text = error.what();
  expect(!text.empty() && text.find('\n') == std::string::npos, "a refusal is one line");
}

/// The completed settings; a discarded value if they are invalid.
Json checked(const Json& settings) {
  try {
    Json complete = complete_settings(settings);
    expect(complete_settings(complete) == complete, "what was taken is taken again as it is");
    return complete;
  } catch (const SettingsError& error) {
    check_refusal(error);
    return Json(Json::value_t::discarded);
  }
}

void check_patch(const Json& before, const Json& patch) {
  Json after;
  try {
    after = before.patch(patch);
  } catch (const Json::exception&) {
    return;
  }
  after = checked(after);
  if (after.is_discarded()) return;
  const Json changes = changes_between(before, after);
  expect(Json::diff(before.patch(forward_patch(changes)), after).empty(), "the history leads there");
  expect(Json::diff(after.patch(backward_patch(changes)), before).empty(), "and back");
  static const Json kSchema = settings_schema();
  try {
    check_named_files(kSchema, after, {before}, {"/var/empty"});
  } catch (const SettingsError& error) {
    check_refusal(error);
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  const std::string input(reinterpret_cast<const char*>(bytes), size);
  const std::size_t split = std::min(input.find('\0'), input.size());
  const Json settings = Json::parse(input.substr(0, split), nullptr, false);
  if (settings.is_discarded()) return 0;
  const Json before = checked(settings);
  const Json patch = Json::parse(input.substr(std::min(split + 1, input.size())), nullptr, false);
  if (!before.is_discarded() && !patch.is_discarded()) check_patch(before, patch);
  return 0;
}
