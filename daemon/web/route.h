// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface of services to the web server: rows of the route table, with handlers that turn a Request
// into a Response. Only the server handles HTTP itself.

#include "base/json.h"
#include "web/view.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sslv {

struct Request {
  std::string method, path;                  // the path is decoded
  std::vector<std::string> matches;          // [0]: the path; then the groups of the route's pattern
  std::map<std::string, std::string> query;  // decoded
  std::string_view body;                     // valid until the handler returns
  std::string address;                       // the client's address
  std::string cookies;                       // the Cookie header
  std::string if_match;                      // the If-Match header; empty: none
  std::stop_token stop{};                    // stopped when the service ends: long work may be abandoned
};

/// A file to send after a response's head, and its size when it was opened.
struct SentFile {
  std::shared_ptr<const int> descriptor;  // closed on destruction
  std::uint64_t bytes = 0;
  std::string before{}, after{};  // sent before and after the file
};

struct Response {
  int status = 200;
  std::string type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers{};
  std::optional<StreamWish> stream{};  // images follow; only for routes that stream, with `type` kStreamType
  std::optional<SentFile> file{};      // a file follows; only for routes that stream
  bool only_tried = false;             // nothing was changed, so it is not in the audit log
};

/// Thrown by a handler to answer with this status and {"error": what()}, extended by the members of `more`.
struct HttpError : std::runtime_error {
  HttpError(int http_status, const std::string& text, Json more_members = Json::object())
      : runtime_error(text), status(http_status), more(std::move(more_members)) {}
  int status;
  Json more;
  std::vector<std::pair<std::string, std::string>> headers{};
};

/// Called from several threads at once. May throw HttpError, SettingsError (answered with 422) and
/// StorageError (507); any other exception is answered with 500.
using Handler = std::function<Response(const Request& request)>;

/// The permission that a route requires.
enum class Needs {
  kByMethod,  // GET: May::kLook; others: May::kChange, and a Gate that is not locked
  kNothing,
  kChange,  // May::kChange, also while the Gate is locked
};

/// Whether a handler may wait for a camera, a disk or the network. kAtOnce is served even while all other
/// handlers hang. kTakesMemory: may wait, too, and takes much memory; one worker runs these handlers one
/// after the other.
enum class Speed { kMayWait, kAtOnce, kTakesMemory };

inline constexpr std::size_t kMaxBodyBytes = 1024 * 1024;
/// Limit for clients that may not change anything.
inline constexpr std::size_t kMaxStrangersBodyBytes = 16 * 1024;

struct Route {
  const char* method;   // GET, POST, PUT, PATCH or DELETE
  const char* pattern;  // regular expression of the whole path
  Handler handle;
  Needs needs = Needs::kByMethod;
  Speed speed = Speed::kMayWait;
  bool streams = false;  // images or a file may follow its response, which is then the last of its connection
  /// Limit for the request's body. Bodies above kMaxBodyBytes are accepted only from clients that may change
  /// something, a few at a time, and only if the pattern is a literal path.
  std::size_t max_body = kMaxBodyBytes;
};

/// A text that viewers subscribe to by name. It is made only while it has subscribers.
class Topic {
 public:
  virtual ~Topic() = default;
  virtual const char* topic_name() const = 0;
  /// Time between two updates.
  virtual std::chrono::milliseconds topic_period() const { return std::chrono::milliseconds(500); }
  /// Called from a thread that may wait.
  virtual Json topic_data() = 0;
};

// ---- for handlers: answers

Response json_response(const Json& json, int status = 200);
Response text_response(std::string text, int status = 200);
Response bytes_response(std::span<const std::uint8_t> bytes, const char* type = "application/octet-stream");

/// Throws HttpError 404 naming `name` if it cannot be read or is not a plain file.
SentFile open_file(const std::filesystem::path& file, const std::string& name);
/// A file to be saved under `name`, for a route that streams. It is sent in chunks, as fast as the
/// client receives them.
Response file_response(SentFile file, const char* type, const std::string& name);
Response file_response(const std::filesystem::path& file, const char* type, const std::string& name);

// ---- for handlers: input from clients

/// Parses a whole number in min .. max from a path part or the query. Throws HttpError 400 naming `name`.
int read_whole_number(std::string_view name, std::string_view text, int min, int max);
/// The same as read_whole_number() for a number with a fraction.
double read_number(std::string_view name, std::string_view text, double min, double max);
/// Parses a whole number from the query like read_whole_number(); `fallback` if it is absent.
int query_number(const Request& request, const std::string& name, int fallback, int min, int max);
/// Returns the index of the query's choice in `choices`; 0 if it is absent. Throws HttpError 400.
std::size_t query_choice(const Request& request, const std::string& name,
                         const std::vector<std::string>& choices);
/// Parses "true" or "false" from the query; false if it is absent. Throws HttpError 400.
bool query_flag(const Request& request, const std::string& name);

/// Parses strict JSON of limited depth, so that no client can exhaust the stack. Throws HttpError 400.
Json parse_json(std::string_view text);
/// Parses the request's body like parse_json(); an empty body is an empty object.
Json body_json(const Request& request);

/// Never throws for text that is not UTF-8 (for example a driver's message): invalid bytes are replaced.
std::string to_text(const Json& json);

}  // namespace sslv
