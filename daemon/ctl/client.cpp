// SPDX-License-Identifier: Apache-2.0
#include "ctl/client.h"

#include "base/plain_text.h"
#include "ctl/change_text.h"
#include "ctl/exchange.h"
#include "ctl/terminal_text.h"

#include <algorithm>
#include <cstddef>
#include <exception>

#include <fmt/format.h>

namespace sslv {

namespace {

/// Throws ClientError.
Json parse_answer(const std::string& text, const std::string& path) {
  try {
    return parse_bounded_json(text);
  } catch (const std::exception&) {
    throw ClientError(fmt::format("{}: the answer is not JSON of a daemon", path));
  }
}

/// Throws ClientError if a text is not UTF-8, as a word of a terminal may be.
std::string body_text(const Json& body) {
  if (!is_utf8(body)) throw ClientError("only UTF-8 can be sent: check your terminal's encoding");
  return json_text(body);
}

/// Text about changes and their authors, the newest first, from SettingsStep[] of docs/openapi.json.
std::string steps_text(const Json& steps) {
  constexpr std::size_t kMax = 3;
  std::string out;
  for (std::size_t i = 0; i < std::min(steps.size(), kMax); ++i) {
    const Json& changes = steps[i].at("changes");
    out += fmt::format("; {} made revision {}", steps[i].at("who").get<std::string>(),
                       steps[i].at("revision").get<std::uint64_t>());
    for (std::size_t j = 0; j < std::min(changes.size(), kMax); ++j)
      out += (j == 0 ? ": " : ", ") + change_text(changes[j]);
    if (changes.size() > kMax) out += fmt::format(", and {} more", changes.size() - kMax);
  }
  if (steps.size() > kMax) out += fmt::format("; and {} revisions before", steps.size() - kMax);
  return out;
}

}  // namespace

ClientError::ClientError(const std::string& text) : runtime_error(escaped_text(text)) {}

std::string path_part(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || c == '.' || c == '~';
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

std::string refusal_text(const std::string& path, int http_status, const std::string& body) {
  std::string bare = fmt::format("{}: HTTP status {}", path, http_status);
  Json answer;
  try {
    answer = plain_answer(parse_answer(body, path));
  } catch (const ClientError&) {
    return bare;
  }
  if (!answer.is_object() || !answer.contains("error") || !answer["error"].is_string()) return bare;
  std::string error = answer["error"].get<std::string>();
  return answer.contains("changed_since") ? error + steps_text(answer["changed_since"]) : error;
}

struct Client::Request {
  const char* method;
  const std::string& path;
  std::string body{};
  const char* type = "application/json";
  std::optional<std::uint64_t> if_revision{};
  std::function<void(std::string_view)> take{};  // gets a 2xx answer's body; null: the body is returned
};

std::string Client::answer(const Request& request) const {
  const auto send = [&](const Request& one) {
    HttpCall call{one.method, one.path, {}, one.body};
    if (!one.body.empty()) call.headers.emplace_back("Content-Type", one.type);
    if (one.if_revision) call.headers.emplace_back("If-Match", std::to_string(*one.if_revision));
    if (!sign_in_->cookie.empty()) call.headers.emplace_back("Cookie", sign_in_->cookie);
    try {
      return one.take ? http_exchange(address_, call, one.take) : http_exchange(address_, call);
    } catch (const ExchangeError& error) {
      throw ClientError(error.what());
    }
  };
  const auto accepted = [](const HttpReply& reply, const std::string& path) {
    if (reply.status < 200 || reply.status > 299)
      throw ClientError(refusal_text(path, reply.status, reply.body));
  };
  HttpReply reply = send(request);
  if (reply.status == 401 && sign_in_->cookie.empty()) {
    const std::string session = "/api/session";
    const HttpReply signed_in = send({"POST", session, body_text(Json{{"password", sign_in_->password()}})});
    accepted(signed_in, session);
    sign_in_->cookie = signed_in.set_cookie.substr(0, signed_in.set_cookie.find(';'));
    reply = send(request);
  }
  accepted(reply, request.path);
  return std::move(reply.body);
}

std::string Client::get(const std::string& path) const {
  return answer({"GET", path});
}

void Client::get_pieces(const std::string& path, const std::function<void(std::string_view)>& take) const {
  Request request{"GET", path};
  request.take = take;
  answer(request);
}

Json Client::get_json(const std::string& path) const {
  return parse_answer(get(path), path);
}

Json Client::post(const std::string& path, const Json& body, std::optional<std::uint64_t> if_revision) const {
  return parse_answer(answer({"POST", path, body_text(body), "application/json", if_revision}), path);
}

Json Client::post_bytes(const std::string& path, const std::string& bytes) const {
  return parse_answer(answer({"POST", path, bytes, "application/octet-stream"}), path);
}

Json Client::patch(const std::string& path, const Json& body,
                   std::optional<std::uint64_t> if_revision) const {
  return parse_answer(answer({"PATCH", path, body_text(body), "application/json-patch+json", if_revision}),
                      path);
}

Json Client::put(const std::string& path, const Json& body) const {
  return parse_answer(answer({"PUT", path, body_text(body)}), path);
}

Json Client::remove(const std::string& path) const {
  return parse_answer(answer({"DELETE", path}), path);
}

}  // namespace sslv
