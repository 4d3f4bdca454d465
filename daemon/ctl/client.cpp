// SPDX-License-Identifier: Apache-2.0
#include "ctl/client.h"

#include "ctl/change_text.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>
#include <httplib.h>

namespace sslv {

namespace {

/// The body of an answer. Throws ClientError.
std::string body_of(const httplib::Result& response, const std::string& address, const std::string& path) {
  if (!response) {
    throw ClientError(fmt::format("no daemon answers at {} ({}); is it running, and is --daemon right?",
                                  address, httplib::to_string(response.error())));
  }
  if (response->status < 200 || response->status > 299)
    throw ClientError(refusal_text(path, response->status, response->body));
  return response->body;
}

httplib::Client client_of(const std::string& address) {
  httplib::Client http(address);
  if (!http.is_valid())
    throw ClientError(fmt::format("\"{}\" is no address; expected http://HOST:PORT", address));
  http.set_connection_timeout(2);
  http.set_read_timeout(30);
  return http;
}

/// Who changed what, the newest first: SettingsStep[] of docs/openapi.json.
std::string steps_text(const Json& steps) {
  constexpr std::size_t kMost = 3;
  std::string out;
  for (std::size_t i = 0; i < std::min(steps.size(), kMost); ++i) {
    const Json& changes = steps[i].at("changes");
    out += fmt::format("; {} made revision {}", steps[i].at("who").get<std::string>(),
                       steps[i].at("revision").get<std::uint64_t>());
    for (std::size_t j = 0; j < std::min(changes.size(), kMost); ++j)
      out += (j == 0 ? ": " : ", ") + change_text(changes[j]);
    if (changes.size() > kMost) out += fmt::format(", and {} more", changes.size() - kMost);
  }
  if (steps.size() > kMost) out += fmt::format("; and {} revisions before", steps.size() - kMost);
  return out;
}

}  // namespace

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
  const Json answer = Json::parse(body, nullptr, false);
  if (!answer.is_object() || !answer.contains("error") || !answer["error"].is_string())
    return fmt::format("{}: HTTP status {}", path, http_status);
  const std::string error = answer["error"].get<std::string>();
  return answer.contains("changed_since") ? error + steps_text(answer["changed_since"]) : error;
}

struct Client::Request {
  const char* method;
  const std::string& path;
  std::string body{};
  const char* type = "application/json";
  std::optional<std::uint64_t> if_revision{};
};

std::string Client::answer(Request request) const {
  httplib::Client http = client_of(address_);
  const auto send = [&] {
    httplib::Request one;
    one.method = request.method;
    one.path = request.path;
    one.body = request.body;
    if (!one.body.empty()) one.set_header("Content-Type", request.type);
    if (request.if_revision) one.set_header("If-Match", std::to_string(*request.if_revision));
    if (!sign_in_->cookie.empty()) one.set_header("Cookie", sign_in_->cookie);
    return http.send(one);
  };
  httplib::Result result = send();
  if (result && result->status == 401 && sign_in_->cookie.empty()) {
    const Json password{{"password", sign_in_->password()}};
    const std::string session = "/api/session";
    const httplib::Result signed_in = http.Post(session, password.dump(), "application/json");
    body_of(signed_in, address_, session);
    const std::string cookie = signed_in->get_header_value("Set-Cookie");
    sign_in_->cookie = cookie.substr(0, cookie.find(';'));
    result = send();
  }
  return body_of(result, address_, request.path);
}

std::string Client::get(const std::string& path) const {
  return answer({"GET", path});
}

Json Client::post(const std::string& path, const Json& body, std::optional<std::uint64_t> if_revision) const {
  return Json::parse(answer({"POST", path, body.dump(), "application/json", if_revision}));
}

Json Client::post_bytes(const std::string& path, const std::string& bytes) const {
  return Json::parse(answer({"POST", path, bytes, "application/octet-stream"}));
}

Json Client::patch(const std::string& path, const Json& body,
                   std::optional<std::uint64_t> if_revision) const {
  return Json::parse(answer({"PATCH", path, body.dump(), "application/json-patch+json", if_revision}));
}

Json Client::put(const std::string& path, const Json& body) const {
  return Json::parse(answer({"PUT", path, body.dump()}));
}

Json Client::remove(const std::string& path) const {
  return Json::parse(answer({"DELETE", path}));
}

}  // namespace sslv
