// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Boost splits the arguments and lays out the help. Values stay text until our own table takes
// them, so that every sentence is ours and the same with every Boost.
#include "command_line.h"

#include <algorithm>
#include <boost/program_options.hpp>
#include <cctype>
#include <set>
#include <sstream>
#include <utility>

#include "ab.h"
#include "methods.h"
#include "python_report.h"
#include "simulate.h"
#include "slim_init/config/edit_distance.h"

namespace slim_init::tools {
namespace {

namespace po = boost::program_options;

constexpr unsigned kHelpWidth = 100;

using Line = CommandLine;
using Table = std::vector<AbOption>;

struct Subcommand {
  const char* name;
  const char* help;
  /// Bound to the fields of a line, whose values are the defaults that the help shows; null: the
  /// arguments are handed on as they are.
  Table (*options)(Line* line);
  int (*run)(const Line& line);
};
const Subcommand kSubcommands[] = {
    {"demo", "Compare slim, vins and openvins on a built-in motion, as recorded and miscalibrated",
     [](Line* line) { return demoOptionTable(&line->demo); },
     [](const Line& line) { return runDemo(line.demo); }},
    {"ab", "Compare initializers on identical windows",
     [](Line* line) { return abOptionTable(&line->ab); },
     [](const Line& line) { return runAb(line.ab); }},
    {"simulate", "Render a motion through a scene: images, IMU data, ground truth",
     [](Line* line) { return simulateOptionTable(&line->simulate); },
     [](const Line& line) { return runSimulate(line.simulate); }},
    {"doctor", "Check a recording and its configuration: why does it not initialize?",
     [](Line* line) { return doctorOptionTable(&line->doctor); },
     [](const Line& line) { return runDoctor(line.doctor); }},
    {"tracks", "Measure the line and point tracks of an image sequence",
     [](Line* line) { return tracksOptionTable(&line->tracks); },
     [](const Line& line) { return runTracks(line.tracks); }},
    {"report", "Tables, pictures and HTML from the folders of one or several runs of ab", nullptr,
     [](const Line& line) { return runReport(line.report); }},
    {"methods", "List the methods with a line each", [](Line* /*line*/) { return Table(); },
     [](const Line& /*line*/) { return runMethods(); }},
    {"options", "List the keys of configuration files",
     [](Line* line) { return optionsOptionTable(&line->options); },
     [](const Line& line) { return runOptions(line.options); }},
};

/// The words as one would type them in a shell, quoted where that is needed.
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
  std::ostringstream out;
  out << purpose << "\nUsage: " << syntax.command << " [OPTION]...\n\n" << syntax.options;
  return out.str();
}

std::string programHelp() {
  std::ostringstream out;
  out << "Drop-in visual-inertial initialization: evaluation tools\n"
      << "Usage: slim_init [OPTION] SUBCOMMAND [OPTION]...\n\n"
      << programSyntax().options << "\nSubcommands:\n";
  for (const Subcommand& subcommand : kSubcommands) {
    std::string name = subcommand.name;
    name.resize(10, ' ');
    out << "  " << name << subcommand.help << "\n";
  }
  out << "\n`slim_init SUBCOMMAND --help` lists the options of a subcommand.\n";
  return out.str();
}

/// "; did you mean --stride?", or nothing when no option is near.
std::string suggestion(const std::string& typed, const po::options_description& options) {
  std::string word = typed.substr(std::min(typed.find_first_not_of('-'), typed.size()));
  std::string nearest;
  std::size_t distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& option : options.options()) {
    const std::string& name = option->long_name();
    // What is cut short is meant as it begins, however much is missing.
    const bool begins = word.size() >= 3 && name.compare(0, word.size(), word) == 0;
    const std::size_t d = begins ? 1 : editDistance(word, name);
    if (d < distance && d < name.size()) {
      distance = d;
      nearest = name;
    }
  }
  return nearest.empty() ? "" : "; did you mean --" + nearest + "?";
}

/// "--name", "-x" or "-x..." rather than a value; "-1" and "-" are values.
bool looksLikeOption(const std::string& token) {
  return token.size() > 1 && token[0] == '-' &&
         (token[1] == '-' || std::isalpha(static_cast<unsigned char>(token[1])) != 0);
}

using Given = std::vector<std::pair<std::string, std::string>>;  // name without dashes, value

/// Splits the arguments into options and their values. Returns an empty string, or the first
/// problem as a sentence. --help wins over unknown and stray arguments.
std::string split(const Syntax& syntax, const std::vector<std::string>& arguments, Given* given) {
  po::command_line_parser parser(arguments);
  using Style = po::command_line_style::style_t;
  // "--str" must not become --stride today and an error when another --str... is added.
  parser.options(syntax.options)
      .style(Style::unix_style & ~Style::allow_guessing & ~Style::allow_sticky)
      .allow_unregistered();
  std::vector<po::option> found;
  try {
    found = parser.run().options;
  } catch (const po::invalid_command_line_syntax& error) {
    const std::string name = error.get_option_name();
    switch (error.kind()) {
      case po::invalid_syntax::missing_parameter:
      case po::invalid_syntax::empty_adjacent_parameter: return name + " needs a value";
      case po::invalid_syntax::extra_parameter: return name + " takes no value";
      default: return error.what();
    }
  } catch (const po::error& error) {
    return error.what();
  }

  std::string problem;
  std::set<std::string> seen;
  for (const po::option& option : found) {
    if (option.string_key == "help") {
      *given = {{"help", ""}};
      return "";
    }
    if (!problem.empty()) continue;  // only --help may still change the answer
    const std::string typed =
        option.original_tokens.empty() ? option.string_key : option.original_tokens.front();
    const std::string value = option.value.empty() ? "" : option.value.front();
    if (option.position_key >= 0) {
      problem = "'" + typed + "' was not expected: " + syntax.command + " takes options only";
    } else if (option.unregistered) {
      const std::string name = typed.substr(0, typed.find('='));
      problem = name + " is not an option of " + syntax.command + suggestion(name, syntax.options);
    } else if (option.original_tokens.size() > 1 && looksLikeOption(value)) {
      // Boost takes whatever follows.
      problem = typed + " needs a value, but '" + value + "' follows; if that is meant, write " +
                typed + "=" + value;
    } else if (!seen.insert(option.string_key).second) {
      problem = "--" + option.string_key + " is given twice";
    } else {
      given->emplace_back(option.string_key, value);
    }
  }
  return problem;
}

bool has(const Given& given, const std::string& name) {
  return std::any_of(given.begin(), given.end(),
                     [&name](const auto& option) { return option.first == name; });
}

std::string setOptions(const Given& given, const std::vector<AbOption>& table) {
  for (const auto& [name, value] : given) {
    const auto option =
        std::find_if(table.begin(), table.end(),
                     [&wanted = name](const AbOption& known) { return known.name == wanted; });
    if (option == table.end()) continue;  // --help, which does not come here
    if (std::string sentence = setOption(*option, value); !sentence.empty()) return sentence;
  }
  return "";
}

}  // namespace

std::string parseCommandLine(const std::vector<std::string>& arguments, CommandLine* line) {
  // What stands before the first word is for the program, what comes after it for the subcommand.
  const auto word = std::find_if(
      arguments.begin(), arguments.end(),
      [](const std::string& argument) { return argument.empty() || argument[0] != '-'; });
  Given given;
  const std::vector<std::string> before(arguments.begin(), word);
  if (std::string problem = split(programSyntax(), before, &given); !problem.empty()) {
    return problem;
  }
  if (has(given, "help")) {
    line->text = programHelp();
    return "";
  }
  if (has(given, "version")) {
    if (word != arguments.end()) return "'" + *word + "' was not expected after --version";
    line->text = "slim_init " SLIM_INIT_VERSION "\n";
    return "";
  }

  std::string known;
  for (const Subcommand& candidate : kSubcommands) {
    known += (known.empty() ? "" : ", ") + std::string(candidate.name);
  }
  if (word == arguments.end()) return "a subcommand is needed: " + known;
  const auto* subcommand =
      std::find_if(std::begin(kSubcommands), std::end(kSubcommands),
                   [&word](const Subcommand& candidate) { return *word == candidate.name; });
  if (subcommand == std::end(kSubcommands)) {
    return "'" + *word + "' is not a subcommand, must be one of: " + known;
  }

  const std::vector<std::string> after(word + 1, arguments.end());
  if (subcommand->options == nullptr) {
    line->report = after;
    line->run = subcommand->run;
    return "";
  }
  const Table table = subcommand->options(line);
  const Syntax syntax = tableSyntax("slim_init " + std::string(subcommand->name), table);
  given.clear();
  if (std::string problem = split(syntax, after, &given); !problem.empty()) return problem;
  if (has(given, "help")) {
    line->text = helpText(syntax, subcommand->help);
    return "";
  }
  line->run = subcommand->run;
  // For the report of `ab`: the run can be repeated by copying the line.
  std::vector<std::string> words = {"slim_init"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  line->ab.command = shellLine(words);
  for (const auto& option : given) line->ab.given.insert(option.first);
  return setOptions(given, table);
}

}  // namespace slim_init::tools
