// SPDX-License-Identifier: Apache-2.0
#include "colors/lut_file.h"

#include "base/base64.h"
#include "base/error.h"
#include "base/json.h"
#include "vision/lut_codec.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/tree.h>

namespace sslv {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kFormat = "ssl-visiond colour table";
constexpr int kVersion = 1;
/// Limit of the file and of its JSON in memory. The largest valid file, an 8-bit table without equal
/// neighbours, takes 43 MiB in base64.
constexpr std::size_t kMaxBytes = 64U << 20;

template <class... Args>
[[noreturn]] void refuse_file(const std::string& file_name, fmt::format_string<Args...> format,
                              Args&&... args) {
  throw SettingsError(file_name + ": " + fmt::format(format, std::forward<Args>(args)...));
}

// ---- our JSON

const Json& get(const Json& json, const char* key, const std::string& file_name) {
  const auto found = json.find(key);
  if (found == json.end()) refuse_file(file_name, "has no \"{}\"", key);
  return *found;
}

/// A whole number 0 .. `most`.
int number_of(const Json& json, const char* key, int most, const std::string& file_name) {
  const Json& value = get(json, key, file_name);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > static_cast<std::uint64_t>(most))
    refuse_file(file_name, "\"{}\" is not a whole number 0 .. {}", key, most);
  return value.get<int>();
}

std::string text_of(const Json& json, const char* key, const std::string& file_name) {
  const Json& value = get(json, key, file_name);
  if (!value.is_string()) refuse_file(file_name, "\"{}\" is not a text", key);
  return value.get<std::string>();
}

PrintColor print_of(const Json& label, const std::string& file_name) {
  const Json& shares = label["print_shares"];
  PrintColor out{};
  const auto is_number = [](const Json& value) {
    return value.is_number_unsigned() && value.get<double>() <= PrintColor::kUnit;
  };
  bool good = shares.is_array() && shares.size() == out.chromaticity.size() &&
              std::all_of(shares.begin(), shares.end(), is_number) &&
              is_number(label.value("print_spread", Json()));
  if (good) {
    for (std::size_t c = 0; c < out.chromaticity.size(); ++c)
      out.chromaticity[c] = shares[c].get<std::uint16_t>();
    out.spread = label["print_spread"].get<std::uint16_t>();
    good = is_print(out);
  }
  if (!good) {
    refuse_file(file_name,
                "\"print_shares\" must be three whole numbers with sum {:g}, and \"print_spread\" a whole "
                "number 0 .. {:g}",
                PrintColor::kUnit, PrintColor::kUnit);
  }
  return out;
}

ColorTable table_of_json(Bytes bytes, const std::string& file_name, const LabelSet& labels) {
  Json json;
  try {
    json = parse_bounded_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, kMaxBytes);
  } catch (const std::length_error& error) {
    refuse_file(file_name, "{}", error.what());
  } catch (const Json::exception& error) {
    refuse_file(file_name, "is not valid JSON: {}", reason_of(error));
  }
  if (!json.is_object() || json.value("format", Json()) != Json(kFormat))
    refuse_file(file_name, "is JSON, but not a colour table: \"format\" is not \"{}\"", kFormat);
  const int version = number_of(json, "version", 1'000'000, file_name);
  if (version != kVersion)
    refuse_file(file_name, "is of version {}; this program reads {}", version, kVersion);
  const int bits = number_of(json, "bits", 255, file_name);

  std::array<std::optional<Label>, label::kMaxCount> ours;
  Prints prints;
  const Json& theirs = get(json, "labels", file_name);
  if (!theirs.is_array()) refuse_file(file_name, "\"labels\" is not a list");
  for (const Json& each : theirs) {
    if (!each.is_object()) refuse_file(file_name, "\"labels\" is not a list of {{value, name, color}}");
    const auto value =
        static_cast<std::size_t>(number_of(each, "value", static_cast<int>(label::kMaxCount) - 1, file_name));
    const std::string name = text_of(each, "name", file_name);
    // LabelSet::name() gives this name to labels without a name: match by value.
    const bool nameless = name == LabelSet::built_in().name(static_cast<Label>(value)) && !labels.find(name);
    ours[value] = nameless ? static_cast<Label>(value) : labels.find(name);
    if (!ours[value]) {
      refuse_file(file_name, "has the label \"{}\", which is not one of {}: add it to own_labels first", name,
                  labels.names());
    }
    if (each.contains("print_shares")) prints[*ours[value]] = print_of(each, file_name);
  }
  const auto runs = from_base64(text_of(json, "runs", file_name));
  if (!runs) refuse_file(file_name, "\"runs\" is not complete base64");
  ColorTable table = decode_runs(*runs, bits, file_name);
  for (Label& label : table.labels) {
    if (!ours[label]) refuse_file(file_name, "has label {} without its name", label);
    label = *ours[label];
  }
  table.prints = prints;
  return table;
}

// ---- SSL-Vision's XML

// A tree of <Var name="..." type="...">. A LUT is a Var of type "blob": base64 of one byte for each cell of 4
// bits of Y, 6 of U, 6 of V, at (Y << 12 | U << 6 | V), and optionally the same number of unused bytes after
// that.
constexpr int kYBits = 4, kUvBits = 6;
constexpr std::size_t kLutBytes = std::size_t{1} << (kYBits + 2 * kUvBits);

struct FreeXml {
  void operator()(xmlDoc* document) const { xmlFreeDoc(document); }
};
using XmlDocument = std::unique_ptr<xmlDoc, FreeXml>;

/// Parses as much as possible of malformed XML. Fetches nothing, expands no entities, and keeps libxml2's
/// limits on depth and length.
XmlDocument parse_xml(Bytes bytes) {
  return XmlDocument(xmlReadMemory(
      reinterpret_cast<const char*>(bytes.data()), static_cast<int>(bytes.size()), nullptr, nullptr,
      XML_PARSE_RECOVER | XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING | XML_PARSE_NOCDATA));
}

std::string_view view_of(const xmlChar* text) {
  return text == nullptr ? std::string_view() : reinterpret_cast<const char*>(text);
}

std::string attribute(const xmlNode& node, const char* name) {
  for (const xmlAttr* each = node.properties; each != nullptr; each = each->next) {
    if (view_of(each->name) == name && each->children != nullptr)
      return std::string(view_of(each->children->content));
  }
  return {};
}

std::string own_text(const xmlNode& node) {
  std::string out;
  for (const xmlNode* child = node.children; child != nullptr; child = child->next) {
    if (child->type == XML_TEXT_NODE || child->type == XML_CDATA_SECTION_NODE) out += view_of(child->content);
  }
  return out;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The number after a word for a camera, as in "Camera 1" or "robocup-ssl-cam-0-lut-yuv.xml".
std::optional<int> camera_in(const std::string& text) {
  const std::string small = lower(text);
  for (const std::string_view word : {"camera ", "camera-", "camera_", "thread ", "cam-", "cam "}) {
    const std::size_t at = small.find(word);
    if (at == std::string::npos) continue;
    const std::size_t begin = at + word.size();
    std::size_t end = begin;
    while (end < small.size() && end < begin + 3 && std::isdigit(static_cast<unsigned char>(small[end])) != 0)
      ++end;
    if (end > begin) return std::stoi(small.substr(begin, end - begin));
  }
  return std::nullopt;
}

ColorTable table_of_blob(const std::string& text, const std::string& name, const std::string& file_name) {
  const auto bytes = from_base64(text);
  if (!bytes) refuse_file(file_name, "\"{}\" is not complete base64: the file was cut off or changed", name);
  if (bytes->size() != kLutBytes && bytes->size() != 2 * kLutBytes) {
    refuse_file(file_name,
                "\"{}\" has {} bytes; a LUT of SSL-Vision (4 bits of Y, 6 of U, 6 of V) has {} or {}", name,
                bytes->size(), kLutBytes, 2 * kLutBytes);
  }
  const auto highest = *std::max_element(bytes->begin(), bytes->begin() + kLutBytes);
  if (highest >= label::kCount) {
    refuse_file(file_name, "\"{}\" has label {}; SSL-Vision's labels are 0 .. {}", name, highest,
                label::kCount - 1);
  }
  ColorTable table;
  const auto side = static_cast<std::size_t>(table.side());
  const int to_uv = table.bits - kUvBits, to_y = table.bits - kYBits;
  Label* out = table.labels.data();
  for (std::size_t u = 0; u < side; ++u) {
    for (std::size_t v = 0; v < side; ++v) {
      const std::uint8_t* in = bytes->data() + (u >> to_uv << kUvBits | v >> to_uv);
      for (std::size_t y = 0; y < side; ++y) *out++ = in[y >> to_y << (2 * kUvBits)];
    }
  }
  return table;
}

struct XmlFinds {
  std::vector<ImportedTable> tables;
  std::vector<std::string> elsewhere;  // referenced files that should hold LUTs
};

void collect(const xmlNode& node, const std::string& path, std::optional<int> camera,
             const std::string& file_name, XmlFinds& finds) {
  for (const xmlNode* child = node.children; child != nullptr; child = child->next) {
    if (child->type != XML_ELEMENT_NODE) continue;
    const std::string name = attribute(*child, "name"), type = lower(attribute(*child, "type"));
    const std::string here = name.empty() ? path : path + '/' + name;
    const std::string file = attribute(*child, "filename");
    if (type == "external" && lower(name + file).find("lut") != std::string::npos)
      finds.elsewhere.push_back(file);
    auto its_camera = camera_in(name);
    if (!its_camera) its_camera = camera_in(file);
    if (!its_camera) its_camera = camera;
    if (type == "blob") {
      const auto whose = its_camera ? its_camera : camera_in(file_name);
      finds.tables.push_back({whose ? fmt::format("camera {}", *whose) : here, whose,
                              "SSL-Vision XML, 4/6/6 bits",
                              table_of_blob(own_text(*child), here, file_name)});
    }
    collect(*child, here, its_camera, file_name, finds);
  }
}

std::vector<ImportedTable> tables_of_xml(Bytes bytes, const std::string& file_name) {
  const XmlDocument document = parse_xml(bytes);
  const xmlNode* root = document ? xmlDocGetRootElement(document.get()) : nullptr;
  if (root == nullptr) refuse_file(file_name, "starts like XML, but is not valid XML");
  XmlFinds finds;
  collect(*root, "", std::nullopt, file_name, finds);
  if (finds.tables.empty()) {
    std::string files;
    for (const std::string& file : finds.elsewhere) files += (files.empty() ? "" : ", ") + file;
    if (files.empty()) refuse_file(file_name, "is XML without a LUT (a Var of type \"blob\")");
    refuse_file(file_name, "has no LUT; it refers to {}: choose one of these", files);
  }
  return std::move(finds.tables);
}

/// SSL-Vision saves empty tables for cameras without colours.
bool is_empty(const ColorTable& table) {
  return std::ranges::all_of(table.labels, [](Label label) { return label == label::kClear; });
}

[[noreturn]] void refuse_empty(const std::string& name) {
  refuse_file(name, "is an empty colour table: no cell has a colour");
}

std::vector<ImportedTable> not_all_empty(std::vector<ImportedTable> tables, const std::string& file_name) {
  if (std::ranges::all_of(tables, is_empty, &ImportedTable::table)) refuse_empty(file_name);
  return tables;
}

}  // namespace

std::string table_json_text(const ColorTable& table, const LabelSet& labels) {
  std::array<bool, label::kMaxCount> occurs{};
  for (const Label label : table.labels) occurs[label] = true;
  Json list = Json::array();
  for (std::size_t value = 0; value < occurs.size(); ++value) {
    if (!occurs[value]) continue;
    Json& one = list.emplace_back(Json{{"value", value},
                                       {"name", labels.name(static_cast<Label>(value))},
                                       {"color", hex(labels.color(static_cast<Label>(value)))}});
    if (const auto& print = table.prints[value]) {
      one["print_shares"] = print->chromaticity;
      one["print_spread"] = print->spread;
    }
  }
  const Json json = {{"format", kFormat},
                     {"version", kVersion},
                     {"bits", table.bits},
                     {"labels", std::move(list)},
                     {"runs", to_base64(encode_runs(table))}};
  return json_text(json, 2) + '\n';
}

std::vector<ImportedTable> import_tables(Bytes bytes, const std::string& file_name, const LabelSet& labels) {
  if (bytes.empty()) refuse_file(file_name, "is empty");
  if (bytes.size() > kMaxBytes) {
    refuse_file(file_name, "has {} bytes; a file of colour tables may have at most {}", bytes.size(),
                kMaxBytes);
  }
  const auto alone = [&](const char* format, ColorTable table) {
    std::vector<ImportedTable> out;
    out.push_back({file_name, std::nullopt, format, std::move(table)});
    return not_all_empty(std::move(out), file_name);
  };
  if (is_lut(bytes)) return alone(".lut", decode_lut(bytes, file_name, labels));
  constexpr std::array<std::uint8_t, 3> kByteOrderMark{0xEF, 0xBB, 0xBF};
  Bytes text = bytes;
  if (text.size() >= kByteOrderMark.size() &&
      std::equal(kByteOrderMark.begin(), kByteOrderMark.end(), text.begin()))
    text = text.subspan(kByteOrderMark.size());
  while (!text.empty() && std::isspace(text.front()) != 0) text = text.subspan(1);
  if (!text.empty() && text.front() == '<') return not_all_empty(tables_of_xml(text, file_name), file_name);
  if (!text.empty() && text.front() == '{') return alone("JSON", table_of_json(text, file_name, labels));
  refuse_file(file_name,
              "is not a colour table: neither a .lut file, nor JSON of this program, nor XML of SSL-Vision");
}

const ImportedTable& choose_table(const std::vector<ImportedTable>& tables, std::optional<std::size_t> index,
                                  std::optional<int> camera, const std::string& file_name) {
  const auto not_empty = [&](const ImportedTable& table) -> const ImportedTable& {
    if (is_empty(table.table)) refuse_empty(file_name + ", " + table.name);
    return table;
  };
  if (index && *index < tables.size()) return not_empty(tables[*index]);
  std::vector<const ImportedTable*> fitting;
  for (const ImportedTable& table : tables) {
    if (!index && (!camera || table.camera == camera)) fitting.push_back(&table);
  }
  if (fitting.size() == 1) return not_empty(*fitting.front());
  std::string names;
  for (std::size_t i = 0; i < tables.size(); ++i)
    names += fmt::format("{}{}: {}", names.empty() ? "" : ", ", i, tables[i].name);
  if (index) refuse_file(file_name, "has no table {}; it has {}", *index, names);
  if (camera)
    refuse_file(file_name, "has {} tables for camera {}; it has {}", fitting.size(), *camera, names);
  refuse_file(file_name, "has several tables; choose one: {}", names);
}

}  // namespace sslv
