// SPDX-License-Identifier: Apache-2.0
#include "web/route.h"

#include "base/error.h"

#include <charconv>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

constexpr std::size_t kMaxShownBytes = 40;

template <class Number>
Number read_any_number(std::string_view name, std::string_view text, Number min, Number max,
                       const char* kind) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (error != std::errc() || end != text.end() || !(value >= min && value <= max)) {
    throw HttpError(400, fmt::format("{}: \"{}\" is not allowed; expected a {} {} .. {}", name,
                                     text.substr(0, kMaxShownBytes), kind, min, max));
  }
  return value;
}

}  // namespace

Response json_response(const Json& json, int status) {
  return {status, "application/json", to_text(json)};
}

Response text_response(std::string text, int status) {
  return {status, "text/plain; charset=utf-8", std::move(text)};
}

Response bytes_response(std::span<const std::uint8_t> bytes, const char* type) {
  return {200, type, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}};
}

SentFile open_file(const std::filesystem::path& file, const std::string& name) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
  struct stat facts {};
  if (opened < 0 || ::fstat(opened, &facts) != 0 || !S_ISREG(facts.st_mode)) {
    if (opened >= 0) ::close(opened);
    throw HttpError(404, fmt::format("{}: cannot be read", name));
  }
  return {std::shared_ptr<const int>(new int(opened),
                                     [](const int* descriptor) {
                                       ::close(*descriptor);
                                       delete descriptor;
                                     }),
          static_cast<std::uint64_t>(facts.st_size)};
}

Response file_response(SentFile file, const char* type, const std::string& name) {
  const std::uint64_t bytes = file.before.size() + file.bytes + file.after.size();
  Response response{200, type, ""};
  response.headers.emplace_back("Content-Disposition", fmt::format("attachment; filename=\"{}\"", name));
  response.headers.emplace_back("Content-Length", std::to_string(bytes));
  response.file = std::move(file);
  return response;
}

Response file_response(const std::filesystem::path& file, const char* type, const std::string& name) {
  return file_response(open_file(file, name), type, name);
}

int read_whole_number(std::string_view name, std::string_view text, int min, int max) {
  return read_any_number(name, text, min, max, "whole number");
}

double read_number(std::string_view name, std::string_view text, double min, double max) {
  return read_any_number(name, text, min, max, "number");
}

int query_number(const Request& request, const std::string& name, int fallback, int min, int max) {
  const auto found = request.query.find(name);
  return found == request.query.end() ? fallback : read_whole_number(name, found->second, min, max);
}

std::size_t query_choice(const Request& request, const std::string& name,
                         const std::vector<std::string>& choices) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return 0;
  std::string known;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == found->second) return i;
    known += (known.empty() ? "\"" : ", \"") + choices[i] + "\"";
  }
  throw HttpError(400, fmt::format("{}: \"{}\" is not allowed; expected one of {}", name,
                                   found->second.substr(0, kMaxShownBytes), known));
}

bool query_flag(const Request& request, const std::string& name) {
  return query_choice(request, name, {"false", "true"}) == 1;
}

Json parse_json(std::string_view text) {
  try {
    return parse_bounded_json(text);
  } catch (const std::length_error& error) {
    throw HttpError(400, error.what());
  } catch (const Json::exception& error) {
    throw HttpError(400, "not JSON: " + shortened(reason_of(error), 300));
  }
}

Json body_json(const Request& request) {
  return request.body.empty() ? Json::object() : parse_json(request.body);
}

std::string to_text(const Json& json) {
  return json_text(json);
}

}  // namespace sslv
