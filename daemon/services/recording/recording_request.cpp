// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_request.h"

#include "base/error.h"
#include "services/recording/match_rule.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::size_t kMaxGivenName = 100;

}  // namespace

void check_keys(const Json& body, std::initializer_list<std::string_view> known) {
  if (!body.is_object()) throw HttpError(400, "expected an object");
  for (const auto& [key, value] : body.items()) {
    if (std::ranges::find(known, key) == known.end())
      throw HttpError(
          400, fmt::format("/{}: is not known here; expected {}", shortened(key), fmt::join(known, ", ")));
  }
}

std::string asked_name(const Json& body) {
  if (!body["name"].is_string()) throw HttpError(400, "/name: expected a text");
  const std::string name = body["name"].get<std::string>();
  const bool is_good = !name.empty() && name.size() <= kMaxGivenName && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' ||
           c == '_' || c == '-';
  });
  if (!is_good)
    throw HttpError(400, fmt::format("/name: expected 1 to {} letters (A to Z), digits, spaces, '_' or '-'",
                                     kMaxGivenName));
  return file_name_part(name);
}

bool asked_pinned(const Request& request) {
  const Json body = body_json(request);
  check_keys(body, {"pinned"});
  if (!body.contains("pinned") || !body["pinned"].is_boolean())
    throw HttpError(400, "/pinned: expected true or false");
  return body["pinned"].get<bool>();
}

}  // namespace sslv
