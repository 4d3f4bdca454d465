// SPDX-License-Identifier: Apache-2.0
#include "web/api.h"
#include "web/http.h"

#include <limits>
#include <string>
#include <vector>

#include <httplib.h>

namespace sslv {
namespace {

constexpr int kMaxNumber = std::numeric_limits<int>::max();

/// The request's body; nothing at all says nothing.
Json body_of(const httplib::Request& request) {
  return request.body.empty() ? Json::object() : parse_json(request.body);
}

/// A choice of the query; the first when it does not say.
std::size_t query_choice(const httplib::Request& request, const std::string& name,
                         const std::vector<std::string>& choices) {
  if (!request.has_param(name)) return 0;
  const std::string given = request.get_param_value(name);
  std::string known;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == given) return i;
    known += (known.empty() ? "\"" : ", \"") + choices[i] + "\"";
  }
  throw HttpError(400, name + ": \"" + given.substr(0, 40) + "\" is not allowed; expected one of " + known);
}

bool query_flag(const httplib::Request& request, const std::string& name) {
  return query_choice(request, name, {"false", "true"}) == 1;
}

void set_bytes(httplib::Response& response, const std::vector<std::uint8_t>& bytes) {
  response.set_content(reinterpret_cast<const char*>(bytes.data()), bytes.size(), "application/octet-stream");
}

void offer_as_file(httplib::Response& response, std::uint32_t camera_id, const char* ending) {
  response.set_header("Content-Disposition", "attachment; filename=\"colours-of-camera-" +
                                                 std::to_string(camera_id) + ending + "\"");
}

}  // namespace

void get_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.state(path_camera(host, request)));
}

void get_color_table(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_bytes(response, host.colors.lut_file(id, query_flag(request, "light")));
}

void edit_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_json(response, host.colors.edit(id, parse_json(request.body), request.remote_addr));
}

void undo_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.undo(path_camera(host, request), request.remote_addr));
}

void redo_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.redo(path_camera(host, request), request.remote_addr));
}

void reset_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.reset(path_camera(host, request), request.remote_addr));
}

void copy_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const Json body = parse_json(request.body);
  if (!body.is_object() || body.size() != 1 || !body.contains("from") || !body["from"].is_number_unsigned())
    throw HttpError(400, R"(expected {"from": the id of another camera})");
  set_json(response, host.colors.copy(id, body["from"].get<int>(), request.remote_addr));
}

void import_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  TableFile file{request.body,
                 request.has_param("name") ? request.get_param_value("name") : "the file",
                 {},
                 query_flag(request, "try")};
  if (request.has_param("table"))
    file.table = static_cast<std::size_t>(query_number(request, "table", 0, 0, kMaxNumber));
  set_json(response, host.colors.import_file(id, file, request.remote_addr));
}

void export_colors(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  if (query_choice(request, "format", {"lut", "json"}) == 1) {
    response.set_content(host.colors.json_file(id), "application/json");
    offer_as_file(response, id, ".json");
  } else {
    set_bytes(response, host.colors.lut_file(id, false));
    offer_as_file(response, id, ".lut");
  }
}

void revert_light(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.revert_light(path_camera(host, request), request.remote_addr));
}

void keep_light(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.keep_light(path_camera(host, request), request.remote_addr));
}

void get_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.learning(path_camera(host, request)));
}

void start_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  set_json(response, host.colors.start_learning(id, body_of(request), request.remote_addr));
  response.status = 202;
}

void cancel_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.cancel_learning(path_camera(host, request)));
}

void accept_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.accept_learning(path_camera(host, request), request.remote_addr));
}

void reject_learning(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  set_json(response, host.colors.reject_learning(path_camera(host, request)));
}

void get_learning_picture(const WebHost& host, const httplib::Request& request, httplib::Response& response) {
  const std::uint32_t id = path_camera(host, request);
  const int picture = read_whole_number("picture", request.matches[2].str(), 0, kMaxNumber);
  const std::size_t labels = query_choice(request, "labels", {"", "before", "after"});
  if (labels > 0) {
    set_bytes(response, host.colors.learning_labels(id, picture, labels == 2));
  } else {
    set_picture(response, host.colors.learning_picture(id, picture), request);
  }
}

}  // namespace sslv
