// SPDX-License-Identifier: Apache-2.0
#include "web/router.h"

#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/plain_text.h"
#include "web/http.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <regex>
#include <span>
#include <utility>

#include <httplib.h>

namespace sslv {
namespace {

using httplib::Server;

/// Lets httplib read a request from memory and write its answer there.
class MemoryStream : public httplib::Stream {
 public:
  MemoryStream(std::string_view request, const std::string& remote_address)
      : request_(request), remote_address_(remote_address) {}

  std::string take_answer() { return std::move(answer_); }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    const std::size_t copied = request_.copy(to, size);
    request_.remove_prefix(copied);
    return static_cast<ssize_t>(copied);
  }
  ssize_t write(const char* from, std::size_t size) override {
    answer_.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int&) const override { ip = remote_address_; }
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  std::string_view request_;
  const std::string& remote_address_;
  std::string answer_;
};

/// Files that the panel's build compresses: NAME.gz beside NAME.
constexpr std::pair<std::string_view, const char*> kPackedTypes[]{
    {".html", "text/html"},        {".js", "text/javascript"}, {".css", "text/css"},
    {".json", "application/json"}, {".svg", "image/svg+xml"},  {".webmanifest", "application/manifest+json"},
};
constexpr std::string_view kPacked = ".gz";

/// Null if files of this type are not compressed.
const char* packed_type(std::string_view path) {
  for (const auto& [ending, type] : kPackedTypes) {
    if (path.ends_with(ending)) return type;
  }
  return nullptr;
}

/// Whether the client accepts gzip.
bool takes_gzip(const std::string& accepted) {
  static const std::regex kGzip(R"((^|[\s,])gzip\s*(;\s*q=(1|0\.0*[1-9])[\d.]*\s*)?(,|$))",
                                std::regex::icase);
  return std::regex_search(accepted, kGzip);
}

/// Returns the panel's compressed version of a file; empty if there is none. Accepts plain names only, so
/// that nothing outside the panel's folder is even searched for.
std::string packed_file(const std::filesystem::path& panel, const std::string& path) {
  static const std::regex kPlain(R"((/[\w-][\w.-]*)+)");
  const std::string name = path == "/" ? "/index.html" : path;
  if (packed_type(name) == nullptr || name.starts_with("/api/") || !std::regex_match(name, kPlain)) return {};
  std::string packed = name + std::string(kPacked);
  std::error_code ignored;
  return std::filesystem::is_regular_file(panel.string() + packed, ignored) ? packed : std::string();
}

/// Body of this thread's current request. Not passed through httplib, which would copy it.
thread_local std::string_view body_of_request;

Request request_of(const httplib::Request& request, const std::stop_token& stop) {
  Request out{.method = request.method,
              .path = request.path,
              .matches = {},
              .query = {},
              .body = body_of_request,
              .address = request.remote_addr,
              .cookies = request.get_header_value("Cookie"),
              .if_match = request.get_header_value("If-Match"),
              .stop = stop};
  for (const auto& match : request.matches) out.matches.push_back(match.str());
  for (const auto& [name, value] : request.params) out.query.emplace(name, value);
  return out;
}

/// Throws HttpError if the client may not do this at present.
void admit(Gate& gate, const Route& route, const Request& request) {
  if (route.needs == Needs::kNothing) return;
  if (route.speed != Speed::kAtOnce) gate.refresh();
  const bool only_looks = route.needs == Needs::kByMethod && route.method == std::string_view("GET");
  const May may = gate.may(request.cookies);
  if (may == May::kNothing) throw HttpError(401, "sign in first");
  if (only_looks) return;
  if (may != May::kChange) throw HttpError(401, "sign in with the admin's password first");
  if (route.needs != Needs::kByMethod) return;
  if (const std::string reason = gate.lock_reason(); !reason.empty()) throw HttpError(423, reason);
}

/// The stream requested by the handler of this thread's current request.
thread_local std::optional<StreamWish> wanted_stream;
/// The file requested by that handler.
thread_local std::optional<SentFile> wanted_file;
/// Whether the answer is the compressed file; whether a compressed file exists.
thread_local bool is_sent_packed = false, may_be_packed = false;
/// Response::only_tried of that handler's response.
thread_local bool only_tried = false;

void set_response(httplib::Response& to, Response&& from) {
  to.status = from.status;
  only_tried = from.only_tried;
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  if (!from.stream && !from.file) {
    to.body = std::move(from.body);
    to.set_header("Content-Type", from.type);
    return;
  }
  wanted_stream = from.stream;
  wanted_file = std::move(from.file);
  // httplib adds no length: the answer ends with the connection.
  to.set_content_provider(from.type, [](std::size_t, httplib::DataSink& sink) {
    sink.done();
    return true;
  });
}

void set_error(httplib::Response& response, int status, std::string_view text,
               const Json& more = Json::object()) {
  Json body{{"error", text}};
  body.update(more);
  response.status = status;
  response.set_content(to_text(body), "application/json");
}

void add_route(Server& server, Gate& gate, const Route& route, const std::stop_token& stop) {
  using Add = Server& (Server::*)(const std::string&, Server::Handler);
  static const std::map<std::string_view, Add> kMethods{{"GET", &Server::Get},
                                                        {"POST", &Server::Post},
                                                        {"PUT", &Server::Put},
                                                        {"PATCH", &Server::Patch},
                                                        {"DELETE", &Server::Delete}};
  const Add add = kMethods.at(route.method);
  (server.*add)(route.pattern, [&gate, &route, &stop](const auto& request, auto& response) {
    const Request ours = request_of(request, stop);
    admit(gate, route, ours);
    set_response(response, route.handle(ours));
  });
}

bool is_read(const httplib::Request& request) {
  return request.method == "GET" || request.method == "HEAD";
}

Server::HandlerResponse refuse_early(const Gate& gate, const httplib::Request& request,
                                     httplib::Response& response) {
  if (const std::string name = request.get_header_value("Host"); !is_own_name(name, gate.names())) {
    set_error(response, 403, not_own_name(name));
    return Server::HandlerResponse::Handled;
  }
  if (request.path.find('\0') != std::string::npos) {  // the file lookup would stop at the zero byte
    set_error(response, 400, "the address contains a zero byte");
    return Server::HandlerResponse::Handled;
  }
  if (is_read(request) ||
      is_same_origin(request.get_header_value("Origin"), request.get_header_value("Host")))
    return Server::HandlerResponse::Unhandled;
  set_error(response, 403, kOtherSite);
  return Server::HandlerResponse::Handled;
}

void answer_exception(const httplib::Request& request, httplib::Response& response,
                      const std::exception_ptr& exception) try {
  std::rethrow_exception(exception);
} catch (const HttpError& error) {
  for (const auto& [name, value] : error.headers) response.set_header(name, value);
  // The standard requires this header; browsers show no sign-in prompt for an unknown scheme.
  if (error.status == 401) response.set_header("WWW-Authenticate", "Session");
  set_error(response, error.status, error.what(), error.more);
} catch (const SettingsError& error) {
  set_error(response, 422, error.what());
} catch (const StorageError& error) {
  set_error(response, 507, error.what());
} catch (const std::exception& error) {
  log::error("web: {} {} failed: {}", request.method, escaped_text(request.target), error.what());
  set_error(response, 500, error.what());
}

/// Adds a text to refusals by httplib itself; refusals by handlers have their own text.
void explain_refusal(std::span<const Route> routes, const httplib::Request& request,
                     httplib::Response& response) {
  if (!response.body.empty()) return;
  if (response.status != 404) return set_error(response, response.status, "not a valid HTTP request");

  std::string allowed;
  for (const Route& route : routes) {
    if (std::regex_match(request.path, std::regex(route.pattern)))
      allowed += (allowed.empty() ? "" : ", ") + std::string(route.method);
  }
  const bool is_api = request.path == "/api" || request.path.starts_with("/api/");
  if (allowed.empty() && !is_api && !is_read(request)) allowed = "GET";
  if (!allowed.empty()) {
    response.set_header("Allow", allowed);
    set_error(response, 405, request.method + " is not allowed here; expected " + allowed);
  } else {
    set_error(response, 404, is_api ? "no such route; docs/openapi.json lists them" : "no such file");
  }
}

Server::Handler explain_missing_panel(const std::filesystem::path& directory) {
  return [directory](const httplib::Request&, httplib::Response& response) {
    response.status = 503;
    response.set_content(
        "The panel was not built when this program started: there is no " +
            (directory / "index.html").string() +
            "\nBuild it with `./run build`, or with `npm ci && npm run build` in webui/, and "
            "start this program again.\n"
            "The API under /api/ works without it.\n",
        "text/plain; charset=utf-8");
  };
}

/// Logs every write, including refused writes.
void write_down(AuditLog& audit, const httplib::Request& request, const httplib::Response& response) {
  if (!is_read(request) && !std::exchange(only_tried, false))
    audit.add(request.remote_addr, request.method, request.target, response.status);
}

/// Sets the headers of a compressed file.
void describe_packed(const httplib::Request& request, httplib::Response& response) {
  if (response.status != 200) return;
  if (may_be_packed) response.set_header("Vary", "Accept-Encoding");
  if (!is_sent_packed) return;
  const std::string_view name =
      std::string_view(request.path).substr(0, request.path.size() - kPacked.size());
  response.headers.erase("Content-Type");
  response.set_header("Content-Type", packed_type(name));
  response.set_header("Content-Encoding", "gzip");
}

/// Only files may be cached.
void set_caching(std::span<const Route> routes, const httplib::Request& request,
                 httplib::Response& response) {
  const bool is_route = std::any_of(routes.begin(), routes.end(),
                                    [&](const Route& route) { return request.path == route.pattern; });
  // The build puts a hash of the content into names under assets/; all other names stay the same.
  const bool has_hashed_name = response.status == 200 && request.path.starts_with("/assets/");
  const bool is_file = response.status == 200 && !is_route && !request.path.starts_with("/api/");
  response.set_header("Cache-Control", has_hashed_name ? "public, max-age=31536000, immutable"
                                       : is_file       ? "no-cache"
                                                       : "no-store");
}

}  // namespace

class Router::HttpServer : public Server {
 public:
  /// The socket is never used, but a server of httplib 0.18 sends no files without one.
  HttpServer() { svr_sock_ = INVALID_SOCKET - 1; }
  using Server::process_request;  // normally called by httplib's sockets
};

namespace {

/// process_request() of the installed version of httplib; 0.18 also takes addresses.
template <class HttpServer>
bool process(HttpServer& server, MemoryStream& stream, const std::string& remote_address, bool& is_last,
             const std::function<void(httplib::Request&)>& prepare) {
  if constexpr (requires { server.process_request(stream, false, is_last, prepare); }) {
    return server.process_request(stream, false, is_last, prepare);
  } else {
    return server.process_request(stream, remote_address, 0, std::string(), 0, false, is_last, prepare);
  }
}

}  // namespace

Router::Router(Gate& gate, std::vector<Route> routes, const std::filesystem::path& panel_directory,
               std::stop_token stop)
    : gate_(gate),
      routes_(std::move(routes)),
      panel_directory_(panel_directory),
      stop_(std::move(stop)),
      server_(std::make_unique<HttpServer>()) {
  for (const Route& route : routes_) {
    add_route(*server_, gate_, route, stop_);
    if (route.streams) stream_paths_.emplace_back(route.pattern);
  }
  server_->set_mount_point("/", panel_directory);
  server_->set_file_extension_and_mimetype_mapping("webmanifest", "application/manifest+json");
  server_->Get("/", explain_missing_panel(panel_directory));
  server_->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    return refuse_early(gate_, request, response);
  });
  server_->set_exception_handler(answer_exception);
  server_->set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
    explain_refusal(routes_, request, response);
  });
  server_->set_post_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    set_caching(routes_, request, response);
    describe_packed(request, response);
    write_down(*audit_, request, response);
  });
  server_->set_keep_alive_timeout(kKeepAliveTimeout.count());
  server_->set_keep_alive_max_count(std::numeric_limits<int>::max());  // only sent, not enforced
  httplib::Headers headers{{"Accept-Ranges", "none"}};
  for (const auto& [name, value] : kSecurityHeaders) headers.emplace(name, value);
  server_->set_default_headers(std::move(headers));
}

Router::~Router() = default;

HttpAnswer Router::answer(std::string_view request, const std::string& remote_address) const {
  constexpr std::string_view kHeaderEnd = "\r\n\r\n";
  const std::size_t header_size = std::min(request.size(), request.find(kHeaderEnd)) + kHeaderEnd.size();
  body_of_request = request.substr(std::min(request.size(), header_size));
  MemoryStream stream(request.substr(0, header_size), remote_address);
  bool is_valid = false, is_last = false, is_head = false;
  std::string cookies;  // httplib destroys its request before the answer is ready
  const auto prepare = [&](httplib::Request& parsed) {
    is_valid = true;
    is_head = parsed.method == "HEAD";
    cookies = parsed.get_header_value("Cookie");
    is_last |= streams(parsed.path);
    if (is_last) {  // makes httplib answer "close"; an HTTP/1.0 request need not ask for it
      parsed.headers.erase("Connection");
      parsed.set_header("Connection", "close");
    }
    const std::string packed = is_read(parsed) ? packed_file(panel_directory_, parsed.path) : std::string();
    may_be_packed = !packed.empty();
    is_sent_packed = may_be_packed && takes_gzip(parsed.get_header_value("Accept-Encoding"));
    if (is_sent_packed) parsed.path = packed;
    // httplib's handling of these headers can cost far more than the request itself: it would unpack a small
    // body to gigabytes, send a large answer a thousand times, or compress it. All bodies are JSON,
    // regardless of their declared type.
    for (const char* name :
         {"Accept-Encoding", "Content-Encoding", "Content-Length", "Content-Type", "Expect", "Range"})
      parsed.headers.erase(name);
    parsed.ranges.clear();
  };
  wanted_stream.reset();
  wanted_file.reset();
  is_sent_packed = may_be_packed = false;
  const bool is_written = process(*server_, stream, remote_address, is_last, prepare);
  HttpAnswer answer{stream.take_answer(), is_written && is_valid && !is_last};
  if (wanted_stream && !is_head) {
    answer.stream = wanted_stream;
    answer.may_look = may_look(gate_, std::move(cookies));
  }
  if (!is_head) answer.file = std::move(wanted_file);
  wanted_file.reset();
  // Called at the end: everything made from the request is free now, no matter how long the handler ran.
  if (request.size() > kLargeRequestBytes) memory_was_used();
  return answer;
}

bool Router::streams(const std::string& path) const {
  return std::any_of(stream_paths_.begin(), stream_paths_.end(),
                     [&](const std::regex& pattern) { return std::regex_match(path, pattern); });
}

const Route* Router::find(std::string_view method, std::string_view target) const {
  if (method == "HEAD") method = "GET";
  const std::string_view path = target.substr(0, target.find('?'));
  const auto found = std::find_if(routes_.begin(), routes_.end(), [&](const Route& route) {
    return method == route.method && path == route.pattern;
  });
  return found == routes_.end() ? nullptr : &*found;
}

Speed Router::speed_of(std::string_view method, std::string_view target) const {
  const Route* route = find(method, target);
  return route == nullptr ? Speed::kMayWait : route->speed;
}

std::size_t Router::max_body_of(std::string_view method, std::string_view target) const {
  const Route* route = find(method, target);
  return route == nullptr ? kMaxBodyBytes : route->max_body;
}

}  // namespace sslv
