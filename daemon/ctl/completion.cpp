// SPDX-License-Identifier: Apache-2.0
#include "ctl/completion.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct Word {
  std::string text, help;
  bool takes_value = false;  // an option that is followed by a value
};

/// A command and the words that may follow it.
struct Node {
  std::string path;  // "/settings/get"; empty: the program itself
  std::vector<Word> commands, options;
};

void add_nodes(const CLI::App& app, const std::string& path, std::vector<Node>& nodes) {
  Node node{path, {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames())
      node.options.push_back({"--" + name, option->get_description(), option->get_expected_max() > 0});
  }
  // Those without a group are hidden in the help, too.
  const auto commands = app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); });
  for (const CLI::App* command : commands)
    node.commands.push_back({command->get_name(), command->get_description()});
  nodes.push_back(std::move(node));
  for (const CLI::App* command : commands) add_nodes(*command, path + "/" + command->get_name(), nodes);
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

std::string bash_script(const std::vector<Node>& nodes, const std::string& program, const std::string& name) {
  std::vector<std::string> paths, with_value;
  std::string choices;
  for (const Node& node : nodes) {
    if (!node.path.empty()) paths.push_back(node.path);
    std::vector<std::string> commands, options;
    for (const Word& word : node.commands) commands.push_back(word.text);
    for (const Word& word : node.options) {
      options.push_back(word.text);
      if (word.takes_value) with_value.push_back(node.path + "/" + word.text);
    }
    choices += fmt::format("    {}) commands=\"{}\" options=\"{}\" ;;\n",
                           node.path.empty() ? "''" : node.path, joined(commands, " "), joined(options, " "));
  }
  return fmt::format(R"(# Completes {program} in bash: source <({program} completion bash)
{name}() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" path="" commands="" options="" i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path/${{COMP_WORDS[i]}}" in
      {paths}) path+="/${{COMP_WORDS[i]}}" ;;
      {with_value}) ((++i)) ;;
    esac
  done
  ((i > COMP_CWORD)) && return  # the value of an option
  case "$path" in
{choices}  esac
  [[ "$current" == -* ]] && commands="$options"
  COMPREPLY=($(compgen -W "$commands" -- "$current"))
}}
complete -o bashdefault -o default -F {name} {program}
)",
                     fmt::arg("program", program), fmt::arg("name", name),
                     fmt::arg("paths", joined(paths, " | ")),
                     fmt::arg("with_value", joined(with_value, " | ")), fmt::arg("choices", choices));
}

/// In single quotes.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

std::string fish_script(const std::vector<Node>& nodes, const std::string& program, const std::string& name) {
  std::vector<std::string> paths, with_value;
  std::string out;
  for (const Node& node : nodes) {
    if (!node.path.empty()) paths.push_back(node.path);
    const std::string here = fmt::format("complete -c {} -n 'test ({}) = \"{}\"'", program, name, node.path);
    for (const Word& word : node.commands)
      out += fmt::format("{} -f -a {} -d {}\n", here, word.text, quoted(word.help));
    for (const Word& word : node.options) {
      if (word.takes_value) with_value.push_back(node.path + "/" + word.text);
      out += fmt::format("{} -l {}{} -d {}\n", here, word.text.substr(2), word.takes_value ? " -r" : "",
                         quoted(word.help));
    }
  }
  return fmt::format(R"(# Completes {program} in fish: {program} completion fish | source
function {name} # the command that is being written
  set -l path ""
  set -l is_value no
  for word in (commandline -opc)[2..]
    if test $is_value = yes
      set is_value no
    else if contains -- $path/$word {paths}
      set path $path/$word
    else if contains -- $path/$word {with_value}
      set is_value yes
    end
  end
  echo "$path"
end
)",
                     fmt::arg("program", program), fmt::arg("name", name),
                     fmt::arg("paths", joined(paths, " ")), fmt::arg("with_value", joined(with_value, " "))) +
         out;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell) {
  const std::string& program = app.get_name();
  std::string name = "_" + program;
  std::replace(name.begin(), name.end(), '-', '_');
  std::vector<Node> nodes;
  add_nodes(app, "", nodes);
  if (shell == "fish") return fish_script(nodes, program, name);
  const std::string bash = bash_script(nodes, program, name);
  // zsh uses bash's script.
  return shell == "zsh" ? fmt::format(
                              "# In zsh: source <({} completion zsh)\nautoload -Uz compinit bashcompinit\n"
                              "(( $+functions[compdef] )) || compinit\nbashcompinit\n",
                              program) +
                              bash
                        : bash;
}

}  // namespace sslv
