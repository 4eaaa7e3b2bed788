// What every command file of the command line has: a function that adds its subcommand to `app`,
// which on parsing runs it and stores its exit code. The references outlive the parsing.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Whole numbers from 0: the parser wraps "-1" around to the largest there is.
inline CLI::Validator WholeUpTo(uint64_t most) { return CLI::Range(uint64_t{0}, most); }

// A number from `least` to `most`; NaN is not, whatever it is compared with.
inline CLI::Validator RealFrom(double least, double most) {
  CLI::Validator range = CLI::Range(least, most);
  return {[=](std::string& text) {
            double value = 0;
            const bool is_number = CLI::detail::lexical_cast(text, value);
            return is_number && std::isnan(value) ? text + " is no number" : range(text);
          },
          range.get_description()};
}

// For numbers of which all are good: the parser would wrap a negative one around.
inline CLI::Validator NotNegative() {
  return {[](const std::string& text) {
            return text.starts_with('-') ? text + " is negative" : std::string();
          },
          "UINT64"};
}

// Adds `name` with its `examples` (whole lines) at the end of the help; `run` is called with the
// options that `declare` filled.
template <typename Options>
CLI::App* AddCommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& examples, int& exit_code,
                     const std::function<void(CLI::App&, Options&)>& declare,
                     const std::function<int(const Options&)>& run) {
  CLI::App* command = app.add_subcommand(name, description);
  command->footer("Examples:\n" + examples);
  // The parser keeps pointers to the options for as long as the command lives.
  auto options = std::make_shared<Options>();
  declare(*command, *options);
  command->callback([options, run, &exit_code] { exit_code = run(*options); });
  return command;
}

}  // namespace sweepstake::cli
