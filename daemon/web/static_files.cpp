// SPDX-License-Identifier: Apache-2.0
#include "web/static_files.h"

#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

namespace sslv {
namespace {

std::string_view mime_type(const std::filesystem::path& file) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kTypes{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".webmanifest", "application/manifest+json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".wasm", "application/wasm"},
      {".txt", "text/plain; charset=utf-8"},
  }};
  const std::string extension = file.extension().string();
  for (const auto& [known, type] : kTypes) {
    if (known == extension) return type;
  }
  return "application/octet-stream";
}

std::optional<std::string> content(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in) return std::nullopt;
  return bytes;
}

}  // namespace

Response StaticFiles::get(std::span<const std::string> path) const {
  std::filesystem::path file = directory_;
  for (const std::string& part : path) file /= part;
  if (path.empty()) file /= "index.html";

  std::optional<std::string> bytes = content(file);
  if (!bytes && path.empty()) {
    return {503,
            "text/plain; charset=utf-8",
            "The panel is not built: there is no " + file.string() +
                "\nBuild it with `./run build`, or with `npm ci && npm run build` in webui/, and load this "
                "page again.\n"
                "The interface under /api/ works without it.\n",
            {{"Cache-Control", "no-store"}}};
  }
  if (!bytes) throw HttpError(404, "no such file");

  // The build puts a hash of the content into the names under assets/; everything else keeps its name.
  const bool has_hashed_name = path.size() > 1 && path.front() == "assets";
  return {200,
          std::string(mime_type(file)),
          std::move(*bytes),
          {{"Cache-Control", has_hashed_name ? "public, max-age=31536000, immutable" : "no-cache"}}};
}

}  // namespace sslv
