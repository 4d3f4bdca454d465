// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a service shows the web server: rows of its route table, with handlers that make a Response of a
// Request. HTTP itself stays in the server.

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
  std::string_view body;                     // of the connection, until the handler returns
  std::string address;                       // of the client
  std::string cookies;                       // the Cookie header
  std::string if_match;                      // the If-Match header; empty: none
  std::stop_token stop{};  // the service ends: what only takes long need not come to its end
};

/// A file that follows a response's head, as it was when it was opened.
struct SentFile {
  std::shared_ptr<const int> descriptor;  // closes it
  std::uint64_t bytes = 0;
  std::string before{}, after{};  // sent around it
};

struct Response {
  int status = 200;
  std::string type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers{};
  std::optional<StreamWish> stream{};  // images follow, of a route that streams; `type` is kStreamType
  std::optional<SentFile> file{};      // follows, of a route that streams
  bool only_tried = false;             // nothing was changed, whatever the method: no line of the audit log
};

/// Thrown by a handler to answer {"error": what()} with this status, and with what stands in `more` beside.
struct HttpError : std::runtime_error {
  HttpError(int http_status, const std::string& text, Json more_members = Json::object())
      : runtime_error(text), status(http_status), more(std::move(more_members)) {}
  int status;
  Json more;
  std::vector<std::pair<std::string, std::string>> headers{};
};

/// Called from several threads at once. May throw HttpError, SettingsError (answered with 422) and
/// StorageError (507); anything else is answered with 500.
using Handler = std::function<Response(const Request& request)>;

/// What a route asks of the client.
enum class Needs {
  kByMethod,  // GET: May::kLook; others: May::kChange, and a Gate that is not locked
  kNothing,
  kChange,  // May::kChange, also while the Gate is locked
};

/// Whether a handler may wait for a camera, a disk or the network. Those that do not are served while all
/// others hang. What takes much memory may wait, too, and one worker handles it, one after the other.
enum class Speed { kMayWait, kAtOnce, kTakesMemory };

inline constexpr std::size_t kMaxBodyBytes = 1024 * 1024;
/// More of a body is not received from clients that may not change anything.
inline constexpr std::size_t kMaxStrangersBodyBytes = 16 * 1024;

struct Route {
  const char* method;   // GET, POST, PUT, PATCH or DELETE
  const char* pattern;  // regular expression of the whole path
  Handler handle;
  Needs needs = Needs::kByMethod;
  Speed speed = Speed::kMayWait;
  bool streams = false;  // images or a file may follow its response, which is the last of its connection then
  /// Bytes of a request. More than kMaxBodyBytes only those may send who may change something, a few at once;
  /// the pattern is the path itself then.
  std::size_t max_body = kMaxBodyBytes;
};

/// A text that viewers may subscribe to by its name. It is made while somebody has.
class Topic {
 public:
  virtual ~Topic() = default;
  virtual const char* topic_name() const = 0;
  /// How often it is made.
  virtual std::chrono::milliseconds topic_period() const { return std::chrono::milliseconds(500); }
  /// Called from a thread that may wait.
  virtual Json topic_data() = 0;
};

// ---- for handlers: answers

Response json_response(const Json& json, int status = 200);
Response text_response(std::string text, int status = 200);
Response bytes_response(std::span<const std::uint8_t> bytes, const char* type = "application/octet-stream");

/// Throws HttpError 404 with `name` when it is not there.
SentFile open_file(const std::filesystem::path& file, const std::string& name);
/// A file to be saved under this name, of a route that streams. It is sent piece by piece, as fast as the
/// client takes it.
Response file_response(SentFile file, const char* type, const std::string& name);
Response file_response(const std::filesystem::path& file, const char* type, const std::string& name);

// ---- for handlers: what clients send

/// A whole number in min .. max from a path part or the query. Throws HttpError 400 naming `name`.
int read_whole_number(std::string_view name, std::string_view text, int min, int max);
/// Likewise, with a fraction.
double read_number(std::string_view name, std::string_view text, double min, double max);
/// Likewise from the query; `fallback` when it does not say.
int query_number(const Request& request, const std::string& name, int fallback, int min, int max);
/// A choice of the query, by its place; the first when it does not say. Throws HttpError 400.
std::size_t query_choice(const Request& request, const std::string& name,
                         const std::vector<std::string>& choices);
/// "true" or "false"; false when the query does not say. Throws HttpError 400.
bool query_flag(const Request& request, const std::string& name);

/// Strict JSON of limited depth, so that no client can exhaust the stack. Throws HttpError 400.
Json parse_json(std::string_view text);
/// The request's body, likewise; an empty one is an empty object.
Json body_json(const Request& request);

/// Never throws for text that is not UTF-8 (a driver's message, say): such bytes are replaced.
std::string to_text(const Json& json);

}  // namespace sslv
