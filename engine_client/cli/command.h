// What the *_command.cc files share: how a subcommand is declared, the checks of its numbers, and
// the options that several commands have.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Accepts whole numbers from `min` to `max`.
CLI::Validator WholeFrom(uint64_t min, uint64_t max);
// Accepts whole numbers from 0 to `max`. Without the check, the parser wraps "-1" around to the
// largest number there is.
CLI::Validator WholeUpTo(uint64_t max);

// Accepts numbers from `min` to `max`. NaN, which passes every comparison of the parser, is
// refused.
CLI::Validator RealFrom(double min, double max);

// Accepts every number without a sign, for options of which all unsigned values are valid.
CLI::Validator NotNegative();

// Accepts these words; for another one the message names the nearest first. `words` must outlive
// the validator.
CLI::Validator OneOf(std::span<const std::string_view> words);

// --daemon HOST:PORT, which is returned and required, and how to connect to it: --tls and the
// --tls-... that imply it, which variables of the environment may give instead.
CLI::Option* AddDaemonOptions(CLI::App& command, DaemonOptions& daemon);
// --json.
void AddJsonFlag(CLI::App& command, bool& json);
// --seed, not negative; `purpose` says what it seeds.
void AddSeedOption(CLI::App& command, uint64_t& seed, const std::string& purpose);

// `words` as one line that a POSIX shell reads back as the same words. Words of letters, digits and
// harmless punctuation stand as they are, the others in single quotes. A pure function.
std::string CommandLine(std::span<char* const> words);

// Adds the subcommand `name`. Its help ends with `examples` (whole lines). `declare` binds the
// command's options; `run` gets them filled in and returns the exit code.
template <typename Options>
CLI::App* AddCommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& examples, int& exit_code,
                     void (*declare)(CLI::App&, Options&),
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
