// SPDX-License-Identifier: Apache-2.0
#include "ctl/terminal_text.h"

#include "base/plain_text.h"

namespace sslv {

Json plain_answer(const Json& answer) {
  if (answer.is_string()) return escaped_text(answer.get_ref<const std::string&>());
  if (answer.is_array()) {
    Json out = Json::array();
    for (const Json& one : answer) out.push_back(plain_answer(one));
    return out;
  }
  if (!answer.is_object()) return answer;
  Json out = Json::object();
  for (const auto& [key, value] : answer.items()) out[escaped_text(key)] = plain_answer(value);
  return out;
}

std::string terminal_json(const Json& answer, int indent) {
  return escaped_lines(json_text(answer, indent));
}

std::string answer_text(const Json& answer, bool as_json, std::string (*text)(const Json&)) {
  return as_json ? terminal_json(answer) + "\n" : text(plain_answer(answer));
}

}  // namespace sslv
