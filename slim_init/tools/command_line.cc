// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Boost splits the arguments and lays out the help. Values stay text until our own table takes
// them, which knows their ranges.
#include "command_line.h"

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <boost/program_options.hpp>
#include <sstream>
#include <utility>

#include "python_report.h"
#include "slim_init/text.h"
#include "slim_init/version.h"
#include "subcommand.h"

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

constexpr unsigned kHelpWidth = 100;

std::vector<Subcommand> subcommands() {
  return {
      demoSubcommand(),
      abSubcommand(),
      simulateSubcommand(),
      doctorSubcommand(),
      {"report", "Tables, pictures and HTML from the folders of one or several runs of ab", {}, {}},
      methodsSubcommand(),
      optionsSubcommand()};
}

/// Options and texts of `slim_init` itself or of a subcommand.
struct Syntax {
  explicit Syntax(const std::string& called)
      : command(called), options("Options", kHelpWidth, kHelpWidth / 2) {
    options.add_options()("help,h", "Print this help and exit");
  }
  std::string command;  ///< "slim_init ab"
  po::options_description options;
};

Syntax programSyntax() {
  Syntax syntax("slim_init");
  syntax.options.add_options()("version", "Print the version and exit");
  return syntax;
}

Syntax tableSyntax(const std::string& command, const std::vector<AbOption>& table) {
  Syntax syntax(command);
  for (const AbOption& option : table) {
    if (std::holds_alternative<bool*>(option.field)) {
      syntax.options.add_options()(option.name.c_str(), option.help.c_str());
      continue;
    }
    auto* value = po::value<std::string>()->value_name(option.value_name);
    const std::string text = valueText(option);
    if (!text.empty()) value->default_value(text);
    const std::string range = rangeText(option);
    const std::string help = option.help + (range.empty() ? "" : "; " + range);
    syntax.options.add_options()(option.name.c_str(), value, help.c_str());
  }
  return syntax;
}

std::string helpText(const Syntax& syntax, const std::string& purpose) {
  return text(purpose, "\nUsage: ", syntax.command, " [OPTION]...\n\n", syntax.options);
}

std::string programHelp() {
  std::ostringstream out;
  out << "Drop-in visual-inertial initialization: evaluation tools\n"
      << "Usage: slim_init [OPTION] SUBCOMMAND [OPTION]...\n\n"
      << programSyntax().options << "\nSubcommands:\n";
  for (const Subcommand& subcommand : subcommands()) {
    std::string name = subcommand.name;
    name.resize(10, ' ');
    out << "  " << name << subcommand.help << "\n";
  }
  out << "\n`slim_init SUBCOMMAND --help` lists the options of a subcommand.\n";
  return out.str();
}

bool asksForHelp(const std::vector<std::string>& arguments) {
  return contains(arguments, "--help") || contains(arguments, "-h");
}

/// Splits the arguments into options and their values. Returns an empty string, or the first
/// problem as a sentence.
std::string split(const Syntax& syntax, const std::vector<std::string>& arguments,
                  po::variables_map* given) {
  po::command_line_parser parser(arguments);
  using Style = po::command_line_style::style_t;
  // "--str" must not become --stride today and an error when another --str... is added.
  parser.options(syntax.options)
      .style(Style::unix_style & ~Style::allow_guessing & ~Style::allow_sticky);
  try {
    const po::parsed_options parsed = parser.run();
    for (const po::option& option : parsed.options) {
      if (option.position_key >= 0) {
        return "'" + option.original_tokens.front() + "' was not expected: " + syntax.command +
               " takes options only";
      }
      const std::string value = option.value.empty() ? "" : option.value.front();
      // Boost takes whatever follows.
      if (option.original_tokens.size() > 1 && value.compare(0, 2, "--") == 0) {
        return option.original_tokens.front() + " needs a value, but '" + value + "' follows";
      }
    }
    po::store(parsed, *given);  // refuses what is given twice
  } catch (const po::error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

std::string shellLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_of(" \t\n'\"\\$`*?&;|<>()[]#~!") == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

std::string parseCommandLine(const std::vector<std::string>& arguments, CommandLine* line) {
  // What stands before the first word is for the program, what comes after it for the subcommand.
  const auto word = std::find_if(
      arguments.begin(), arguments.end(),
      [](const std::string& argument) { return argument.empty() || argument[0] != '-'; });
  const std::vector<std::string> before(arguments.begin(), word);
  if (asksForHelp(before)) {
    line->text = programHelp();
    return "";
  }
  po::variables_map of_program;
  if (std::string problem = split(programSyntax(), before, &of_program); !problem.empty()) {
    return problem;
  }
  if (of_program.count("version") > 0) {
    if (word != arguments.end()) return "'" + *word + "' was not expected after --version";
    line->text = text("slim_init ", kVersion, "\n");
    return "";
  }

  const std::vector<Subcommand> all = subcommands();
  std::vector<std::string> names;
  for (const Subcommand& one : all) names.push_back(one.name);
  const std::string known = boost::algorithm::join(names, ", ");
  if (word == arguments.end()) return "a subcommand is needed: " + known;
  const auto subcommand = std::find_if(
      all.begin(), all.end(), [&word](const Subcommand& one) { return *word == one.name; });
  if (subcommand == all.end()) {
    return "'" + *word + "' is not a subcommand, must be one of: " + known;
  }

  const std::vector<std::string> after(word + 1, arguments.end());
  if (subcommand->run == nullptr) {  // the Python package reads the arguments
    line->run = [after] { return runReport(after); };
    return "";
  }
  const Syntax syntax = tableSyntax("slim_init " + subcommand->name, subcommand->options);
  if (asksForHelp(after)) {
    line->text = helpText(syntax, subcommand->help);
    return "";
  }
  po::variables_map given;
  if (std::string problem = split(syntax, after, &given); !problem.empty()) return problem;
  // For the report of `ab`: the run can be repeated by copying the line.
  std::vector<std::string> words = {"slim_init"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  Typed typed = {shellLine(words), {}};
  for (const AbOption& option : subcommand->options) {
    const po::variable_value& value = given[option.name];
    if (value.empty() || value.defaulted()) continue;
    typed.options.insert(option.name);
    std::string problem = setOption(option, value.as<std::string>());
    if (!problem.empty()) return problem;
  }
  line->run = [run = subcommand->run, typed] { return run(typed); };
  return "";
}

}  // namespace slim_init::tools
