// SPDX-License-Identifier: Apache-2.0
// settings_page VERSION: the manual page ssl-visiond-settings(5), made from the settings' own schema.
#include "config/config.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include <fmt/format.h>

namespace {

using namespace sslv;

/// Escapes text for roff: characters that it would interpret as commands or replace.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'' || c == '"' || c == '.') {
      out += (out.empty() ? "\\&" : "") + std::string(1, c);
    } else {
      out += c;
    }
  }
  return out;
}

std::string words_of(const Json& list, const char* between) {
  std::string out;
  for (const Json& one : list)
    out += (out.empty() ? "" : between) + (one.is_string() ? one.get<std::string>() : one.dump());
  return out;
}

std::string type_of(const Json& schema) {
  if (schema.contains("const")) return words_of(Json::array({schema["const"]}), "");
  if (schema.contains("enum")) return "one of " + words_of(schema["enum"], ", ");
  const Json type = schema.value("type", Json());
  std::string out = type.is_array()    ? words_of(type, " or ")
                    : type.is_string() ? type.get<std::string>()
                                       : "";
  if (schema.contains("minimum"))
    out += fmt::format(" {} to {}", schema["minimum"].get<double>(), schema["maximum"].get<double>());
  if (const std::string unit = schema.value("x-unit", ""); !unit.empty()) out += " " + unit;
  if (schema.contains("items") && !schema["items"].contains("properties"))
    out += " of " + type_of(schema["items"]);
  return out;
}

void print_entry(const std::string& key, const Json& schema) {
  std::string facts = type_of(schema);
  const Json standard = schema.value("default", Json());
  // Defaults of groups repeat the defaults of their members.
  if (standard.is_primitive() && schema.contains("default")) facts += "; default " + standard.dump();
  fmt::print(".TP\n.B {}\n{}.", roff(key), roff(facts));
  if (const std::string help = schema.value("description", ""); !help.empty())
    fmt::print("\n.br\n{}.", roff(help));
  fmt::print("\n");
}

void print_below(const std::string& key, const Json& schema) {
  if (schema.contains("properties")) {
    for (const auto& [name, one] : schema["properties"].items()) {
      const std::string below = key + "/" + name;
      if (!one.contains("properties") || one.value("type", Json()).is_array()) print_entry(below, one);
      print_below(below, one);
    }
  }
  if (schema.contains("items") && schema["items"].contains("properties"))
    print_below(key + "/*", schema["items"]);
  if (schema.contains("oneOf")) {
    for (const Json& one : schema["oneOf"]) {
      fmt::print(".SS {}: {}\n", roff(key), roff(one.at("title").get<std::string>()));
      print_below(key, one);
    }
    fmt::print(".SS Others\n");
  }
}

void print_page(const std::string& version) {
  fmt::print(R"(.\" Made from the settings' schema by settings_page.cpp.
.TH SSL\-VISIOND\-SETTINGS 5 "" "ssl\-visiond {}" "ssl\-visiond"
.SH NAME
ssl\-visiond\-settings \- settings file of the vision service
.SH SYNOPSIS
.I /etc/ssl\-visiond/settings.json
.SH DESCRIPTION
One JSON object. Missing values have defaults. Invalid values are refused, by the service at its start and by
.BR "ssl\-visiond \-\-check\-config" ;
the message names key, value and what is allowed.
A key
.B \(dq//\(dq
in any object is a comment.
.PP
The service never writes this file. Changes made at runtime are stored as a JSON Patch on it in
.IR /var/lib/ssl\-visiond/settings.json ,
so later edits of the file take effect too, except for values that were changed at runtime.
.B ssl\-visiond \-\-print\-config
shows the whole tree with all defaults.
.SH SETTINGS
Listed by JSON Pointer;
.B *
stands for any entry of a list.
)",
             roff(version));
  print_below("", settings_schema());
  fmt::print(R"(.SH EXAMPLES
.I /usr/share/doc/ssl\-visiond/examples
has a field with simulated cameras and one with GigE cameras.
.SH SEE ALSO
.BR ssl\-visiond (8),
.BR ssl\-visionctl (1),
.BR ssl\-visionlab (1)
)");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    print_page(argc > 1 ? argv[1] : "");
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "settings_page: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
