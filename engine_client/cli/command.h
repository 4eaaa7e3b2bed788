// Used by all *_command.cc files: functions that declare a subcommand and check its numbers, and
// options that several commands have.
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
#include "sweepstake/frame_sample.h"

namespace sweepstake::cli {

// Accepts whole numbers from `min` to `max`.
CLI::Validator WholeFrom(uint64_t min, uint64_t max);
// Accepts whole numbers from 0 to `max`. Without this check, the parser would turn "-1" into the
// largest 64-bit number.
CLI::Validator WholeUpTo(uint64_t max);

// Accepts numbers from `min` to `max`. Rejects NaN, which the parser's own range check accepts.
CLI::Validator RealFrom(double min, double max);

// Rejects negative numbers, for options that accept every unsigned value.
CLI::Validator NotNegative();

// Accepts the given words. For another word, the error message lists them, the nearest first.
// `words` must outlive the validator.
CLI::Validator OneOf(std::span<const std::string_view> words);

// Adds --daemon HOST:PORT, which is required and returned, and the options of the connection:
// --tls, the --tls-... options (which imply --tls), and --token-file. The --tls-... options and
// --token-file can also be set by environment variables.
CLI::Option* AddDaemonOptions(CLI::App& command, DaemonOptions& daemon);
// Add an option with a duration, and --weights. `set` receives the value, which is not checked.
void AddIntervalOption(CLI::App& command, const std::string& name, const std::string& help,
                       std::function<void(int64_t ns)> set);
void AddWeightsOption(CLI::App& command, std::function<void(const RewardWeights&)> set);
// Adds --interval, --cooldown, --settling and --weights for the fields of `options`, which is a
// decision::DecisionOptions or a DecisionRules. decision::NumberProblems checks the values, after
// parsing.
template <typename Options>
void AddDecisionOptions(CLI::App& command, Options& options) {
  AddIntervalOption(command, "--interval",
                    "Time between two decisions; AI Decides decides at least every second "
                    "(default: the decider's, 2s)",
                    [&options](int64_t ns) { options.decision_interval_ns = ns; });
  AddIntervalOption(command, "--cooldown",
                    "Minimum time between two switches; AI Decides may wait less (default: the "
                    "decider's, 40s)",
                    [&options](int64_t ns) { options.cooldown_ns = ns; });
  AddIntervalOption(command, "--settling",
                    "Frame time after a switch that is excluded from learning; AI Decides: at most "
                    "1s (default: the decider's, 2s)",
                    [&options](int64_t ns) { options.settling_ns = ns; });
  AddWeightsOption(command,
                   [&options](const RewardWeights& weights) { options.weights = weights; });
}
// Adds --json.
void AddJsonFlag(CLI::App& command, bool& json);
// Adds --seed, which must not be negative. Its help text is "Seed of " + `purpose`.
void AddSeedOption(CLI::App& command, uint64_t& seed, const std::string& purpose);

// Returns `words` as one line that a POSIX shell parses into the same words. Puts a word in single
// quotes unless it consists of letters, digits and harmless punctuation. A pure function.
std::string CommandLine(std::span<char* const> words);

// The parameters of all functions that add commands. Everything is borrowed until `app` has parsed.
struct CommandContext {
  CLI::App& app;  // the commands are added to it
  Terminal& terminal;
  int& exit_code;                   // set by the command that the user chose
  const std::string& command_line;  // as typed by the user; reports contain it
};

// Adds the subcommand `name`. Its help ends with `examples` (whole lines). `declare` connects the
// command's options to the fields of Options. After parsing, `run` gets these fields and returns
// the exit code.
template <typename Options>
CLI::App* AddCommand(const CommandContext& context, const std::string& name,
                     const std::string& description, const std::string& examples,
                     void (*declare)(CLI::App&, Options&),
                     const std::function<int(const Options&, Terminal&)>& run) {
  CLI::App* command = context.app.add_subcommand(name, description);
  command->footer("Examples:\n" + examples);
  command->option_defaults()->always_capture_default();
  // The parser keeps pointers to the options as long as the command exists.
  auto options = std::make_shared<Options>();
  declare(*command, *options);
  command->callback([options, run, &terminal = context.terminal, &exit_code = context.exit_code] {
    exit_code = run(*options, terminal);
  });
  return command;
}

// Adds a subcommand that only groups other subcommands, and returns the context to add these.
CommandContext AddGroup(const CommandContext& context, const std::string& name,
                        const std::string& description, const std::string& examples);

}  // namespace sweepstake::cli
