// Shared by the *_command.cc files: declaring a subcommand, checking its numbers, and the options
// that several commands have.
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
// largest 64-bit number.
CLI::Validator WholeUpTo(uint64_t max);

// Accepts numbers from `min` to `max`. Rejects NaN, which would pass the parser's own comparisons.
CLI::Validator RealFrom(double min, double max);

// Rejects negative numbers, for options that accept every unsigned value.
CLI::Validator NotNegative();

// Accepts these words. For another word the message lists them, the nearest first. `words` must
// outlive the validator.
CLI::Validator OneOf(std::span<const std::string_view> words);

// Adds --daemon HOST:PORT, which is required and returned, and the options of the connection:
// --tls, the --tls-... options, which imply it, and --token-file. Environment variables can set the
// latter.
CLI::Option* AddDaemonOptions(CLI::App& command, DaemonOptions& daemon);
// Adds --json.
void AddJsonFlag(CLI::App& command, bool& json);
// Adds --seed, which must not be negative. Its help text is "Seed of " + `purpose`.
void AddSeedOption(CLI::App& command, uint64_t& seed, const std::string& purpose);

// Returns `words` as one line that a POSIX shell parses into the same words. Puts a word in single
// quotes unless it consists of letters, digits and harmless punctuation. A pure function.
std::string CommandLine(std::span<char* const> words);

// What functions that add commands share. Everything is borrowed until `app` has parsed.
struct CommandContext {
  CLI::App& app;  // gets the commands
  Terminal& terminal;
  int& exit_code;                   // of the command that the user chose
  const std::string& command_line;  // what the user typed; reports keep it
};

// Adds the subcommand `name`. Its help ends with `examples` (whole lines). `declare` binds the
// command's options; `run` gets them filled in and returns the exit code.
template <typename Options>
CLI::App* AddCommand(const CommandContext& context, const std::string& name,
                     const std::string& description, const std::string& examples,
                     void (*declare)(CLI::App&, Options&),
                     const std::function<int(const Options&, Terminal&)>& run) {
  CLI::App* command = context.app.add_subcommand(name, description);
  command->footer("Examples:\n" + examples);
  // The parser keeps pointers to the options for as long as the command lives.
  auto options = std::make_shared<Options>();
  declare(*command, *options);
  command->callback([options, run, &terminal = context.terminal, &exit_code = context.exit_code] {
    exit_code = run(*options, terminal);
  });
  return command;
}

// Adds a subcommand that has only subcommands, and returns the context for these.
CommandContext AddGroup(const CommandContext& context, const std::string& name,
                        const std::string& description, const std::string& examples);

}  // namespace sweepstake::cli
