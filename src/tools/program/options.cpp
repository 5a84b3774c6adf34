#include "tools/program/options.h"

#include "proximity_server/scene/model/names.h"
#include "system/whole_file.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <thread>

namespace proximity_server::tools {
namespace {

namespace po = boost::program_options;

constexpr unsigned kLineLength = 100;  // of the help
constexpr int kMaxThreads = 1024;
const char* const kArguments = "Arguments";

/// The options below a heading, as Boost describes them.
po::options_description tableOf(const std::vector<Option>& options, const std::string& heading) {
  po::options_description table(heading, kLineLength);
  for (const Option& option : options) {
    if (option.heading != heading) continue;
    std::string name = option.name.substr(option.name.find_first_not_of('-')), text = option.description;
    if (name == "help") name += ",h";
    if (!option.needs.empty()) text += "; needs " + option.needs;
    for (const std::string& other : option.excludes)
      text += (other == *option.excludes.begin() ? "; not with " : ", ") + other;
    if (option.type.empty())
      table.add_options()(name.c_str(), text.c_str());
    else
      table.add_options()(name.c_str(), po::value<std::string>()->value_name(option.type), text.c_str());
  }
  return table;
}

/// All options without the arguments, headings in the order in which they appeared.
po::options_description tablesOf(const std::vector<Option>& options) {
  po::options_description tables(kLineLength);
  std::set<std::string> done{kArguments};
  for (const Option& option : options)
    if (done.insert(option.heading).second) tables.add(tableOf(options, option.heading));
  return tables;
}

/// Lets the option that was given, or the next argument, read its text.
void read(const po::option& given, std::vector<Option>& options) {
  const bool is_argument = given.value == given.original_tokens;  // the string_key of "--=x" is empty, too
  const auto isMeant = [&](const Option& option) {
    return is_argument ? option.heading == kArguments && !option.is_given : option.name == "--" + given.string_key;
  };
  const auto option = std::find_if(options.begin(), options.end(), isMeant);
  if (option == options.end())
    throw std::invalid_argument("The following argument was not expected: " + given.original_tokens.front());
  if (option->is_given && !option->is_repeatable && !option->type.empty())
    throw std::invalid_argument(option->name + " is given twice");
  option->is_given = true;
  option->texts.push_back(given.value.empty() ? "" : given.value.front());
  naming(option->name, [&] { option->read(option->texts.back()); });
}

/// The option of that name; it must be there.
Option& named(const std::string& name, std::vector<Option>& options) {
  return options.at(static_cast<std::size_t>(scene::findNamed(options, name)));
}

/// Throws std::invalid_argument unless the options and arguments that are given go together.
void requireConsistent(std::vector<Option>& options) {
  for (const Option& option : options) {
    if (option.is_required && !option.is_given) throw std::invalid_argument(option.name + " is required");
    if (!option.is_given) continue;
    if (!option.needs.empty() && !named(option.needs, options).is_given)
      throw std::invalid_argument(option.name + " requires " + option.needs);
    for (const std::string& other : option.excludes)
      if (named(other, options).is_given) throw std::invalid_argument(option.name + " excludes " + other);
  }
}

}  // namespace

ProgramOptions::ProgramOptions(const std::string& program, const std::string& about)
    : program_(program), about_(about) {
  const auto ignore = [](const std::string&) {};
  add("--help", "", "print this text", ignore);
  add("--version", "", "print the version", ignore);
}

Option& ProgramOptions::add(const std::string& name, const std::string& type, const std::string& description,
                            const std::function<void(const std::string& text)>& read) {
  return options_.emplace_back(Option{name, type, description, read, name[0] == '-' ? heading_ : kArguments, "", {}});
}

void ProgramOptions::atMostOneOf(const std::set<std::string>& names) {
  for (const std::string& one : names)
    for (const std::string& other : names)
      if (one != other) (*this)[one].excludes.insert(other);
}

Option& ProgramOptions::operator[](const std::string& name) { return named(name, options_); }

std::optional<int> ProgramOptions::parse(int argc, const char* const* argv) {
  constexpr int kStyle = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
  const auto fail = [&](const std::exception& error) {
    std::cerr << program_ << ": " << system::readable(error.what()) << "\nRun with --help for more information."
              << std::endl;
    return 1;
  };
  try {
    const po::options_description known = tablesOf(options_);
    const po::parsed_options all =
        po::command_line_parser(argc, argv).options(known).style(kStyle).allow_unregistered().run();
    for (const po::option& given : all.options) {
      const bool wants_help = given.string_key == "help", wants_version = given.string_key == "version";
      if (wants_help) std::cout << help();
      if (wants_version) std::cout << program_ << " of proximity_server " PROXIMITY_VERSION "\n";
      if (wants_help || wants_version) return 0;
      read(given, options_);
    }
    requireConsistent(options_);
    return std::nullopt;
  } catch (const po::error& error) {  // a text that is missing, or that a flag has
    return fail(error);
  } catch (const std::invalid_argument& error) {
    return fail(error);
  }
}

void ProgramOptions::claimFiles() const {
  system::FileRoles& roles = system::FileRoles::ofProcess();
  const auto has = [](const Option& option, const char* word) { return option.type.find(word) != std::string::npos; };
  for (const Option& option : options_)
    for (const std::string& text : option.texts)
      if (has(option, "FILE") && !option.is_output) roles.addInput(option.name, text);
  for (const Option& option : options_) {
    for (const std::string& text : option.texts) {
      if (!option.is_output || text.empty()) continue;
      roles.addOutput(option.name, text);
      if (!has(option, "DIR")) naming(option.name, [&] { system::requireWritable(text); });
    }
  }
  roles.requireNoInput("/dev/stdout");
}

std::string ProgramOptions::help() const {
  const po::options_description options = tablesOf(options_), arguments = tableOf(options_, kArguments);
  std::ostringstream table, text;
  arguments.print(table, options.get_option_column_width());
  std::string names, rows = arguments.options().empty() ? "" : "\n" + table.str();
  for (const Option& option : options_) {
    if (option.heading != kArguments) continue;
    names += option.is_required ? " " + option.name : " [" + option.name + "]";
    rows.replace(rows.find("\n  --" + option.name + ' ') + 3, 2, "  ");  // Boost writes dashes before every name
  }
  text << about_ << "\n\nUsage: " << program_ << " [OPTIONS]" << names << '\n' << rows << options;
  if (!footer_.empty()) text << '\n' << footer_ << '\n';
  return text.str();
}

double readLength(const std::string& text, double least) {
  const std::optional<double> value = finiteNumber(text);
  if (value && *value >= least) return *value;
  std::ostringstream what;
  what << "'" << text << "' is not a finite length of at least " << least << " m";
  throw std::invalid_argument(what.str());
}

long readCount(const std::string& text, long least, long most) {
  const std::optional<long> value = signedNumberIn<long>(text);
  if (!value || *value < least || *value > most)
    throw std::invalid_argument("'" + text + "' is not a whole number from " + std::to_string(least) + " to " +
                                std::to_string(most));
  return *value;
}

double readPositive(const std::string& text) {
  const std::optional<double> value = finiteNumber(text);
  if (!value || *value <= 0.0) throw std::invalid_argument("'" + text + "' is not a positive number");
  return *value;
}

void addThreads(ProgramOptions& program, int& value) {
  value = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  addCount(program, "--threads", value, 1, kMaxThreads, "default: all cores; the output is the same for any number");
}

}  // namespace proximity_server::tools
