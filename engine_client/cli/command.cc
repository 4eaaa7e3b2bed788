#include "engine_client/cli/command.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "engine_client/cli/io/duration.h"
#include "engine_client/text/names.h"

namespace sweepstake::cli {
namespace {

constexpr std::string_view kHarmless =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";

std::string Quoted(std::string_view word) {
  if (!word.empty() && word.find_first_not_of(kHarmless) == std::string_view::npos) {
    return std::string(word);
  }
  std::string quoted = "'";
  for (const char character : word) {
    // A quoted text cannot contain a single quote. Close the quotes, add an escaped quote, and open
    // them again.
    if (character == '\'') {
      quoted += "'\\''";
    } else {
      quoted += character;
    }
  }
  return quoted + '\'';
}

// Returns whether the text is a whole number of any length, with or without a sign.
bool IsWhole(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

TlsOptions& Tls(DaemonOptions& daemon) { return daemon.tls ? *daemon.tls : daemon.tls.emplace(); }

// Adds a TLS option and the environment variable that can set it, such as SWEEPSTAKE_CLIENT_TLS_CA
// for --tls-ca. `daemon` must outlive the command.
void AddTlsOption(CLI::App& command, const std::string& name, std::string TlsOptions::*field,
                  DaemonOptions& daemon, const std::string& help) {
  std::string variable = "SWEEPSTAKE_CLIENT";
  for (const char c : name.substr(1)) {
    variable += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  command
      .add_option_function<std::string>(
          name, [&daemon, field](const std::string& value) { Tls(daemon).*field = value; }, help)
      ->envname(variable);
}

}  // namespace

CLI::Validator WholeFrom(uint64_t min, uint64_t max) {
  CLI::Validator range = CLI::Range(min, max);
  return {[=](std::string& text) {
            return IsWhole(text) ? range(text) : text + " is not a whole number";
          },
          range.get_description()};
}

CLI::Validator WholeUpTo(uint64_t max) { return WholeFrom(0, max); }

CLI::Validator RealFrom(double min, double max) {
  CLI::Validator range = CLI::Range(min, max);
  return {[=](std::string& text) {
            double value = 0;
            const bool is_number = CLI::detail::lexical_cast(text, value) && !std::isnan(value);
            return is_number ? range(text) : text + " is not a number";
          },
          range.get_description()};
}

CLI::Validator NotNegative() {
  return {[](const std::string& text) {
            return text.starts_with('-') ? text + " is negative" : std::string();
          },
          "UINT64"};
}

CLI::Validator OneOf(std::span<const std::string_view> words) {
  std::string all;
  for (const std::string_view word : words) all.append(all.empty() ? "{" : ",").append(word);
  return {[words](const std::string& text) {
            return std::find(words.begin(), words.end(), text) == words.end()
                       ? text::UnknownName("value", text, words)
                       : std::string();
          },
          all + "}"};
}

CLI::Option* AddDaemonOptions(CLI::App& command, DaemonOptions& daemon) {
  CLI::Option* address =
      command.add_option("--daemon", daemon.address, "Address of sweepstaked, HOST:PORT");
  command.add_flag_callback(
      "--tls", [&daemon] { Tls(daemon); }, "Connect with TLS; the options below imply it");
  AddTlsOption(command, "--tls-ca", &TlsOptions::ca_file, daemon,
               "PEM file of the certificate authorities to trust (default: the system's)");
  AddTlsOption(command, "--tls-cert", &TlsOptions::cert_file, daemon,
               "PEM file of your certificate, if the daemon requires one");
  AddTlsOption(command, "--tls-key", &TlsOptions::key_file, daemon,
               "PEM file of your certificate's private key");
  AddTlsOption(command, "--tls-server-name", &TlsOptions::server_name, daemon,
               "Host name in the daemon's certificate, if it differs from that of --daemon");
  // The token can be set only by a variable or a file, not by an option, because other users can
  // read the arguments of a process.
  if (const char* token = std::getenv("SWEEPSTAKE_CLIENT_TOKEN")) daemon.token.text = token;
  command
      .add_option_function<std::string>(
          "--token-file",
          [&daemon](const std::string& file) {
            daemon.token = {file, ""};
          },
          "File with the token that the daemon requires; or set SWEEPSTAKE_CLIENT_TOKEN to the "
          "token")
      ->envname("SWEEPSTAKE_CLIENT_TOKEN_FILE");
  return address->required();
}

void AddIntervalOption(CLI::App& command, const std::string& name, const std::string& help,
                       std::function<void(int64_t ns)> set) {
  command
      .add_option_function<std::string>(
          name,
          [name, set = std::move(set)](const std::string& text) {
            const auto duration_ns = ParseDuration(text, /*min_ns=*/0);
            if (!duration_ns.ok()) throw CLI::ValidationError(name, duration_ns.status().message());
            set(static_cast<int64_t>(*duration_ns));
          },
          help)
      ->type_name("DURATION");
}

void AddWeightsOption(CLI::App& command, std::function<void(const RewardWeights&)> set) {
  command
      .add_option_function<std::vector<double>>(
          "--weights",
          [set = std::move(set)](const std::vector<double>& given) {
            if (given.size() != 4) {
              throw CLI::ValidationError("--weights",
                                         "give four numbers, such as 0.55,0.25,0.12,0.08");
            }
            set({given[0], given[1], given[2], given[3]});
          },
          "Weights of the paper's reward, whose sum is 1: frame rate, detection time, memory, "
          "checks; for policy paper (default: the decider's, 0.55,0.25,0.12,0.08)")
      ->delimiter(',')
      ->type_name("W,W,W,W");
}

void AddJsonFlag(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "One JSON document on stdout");
}

void AddSeedOption(CLI::App& command, uint64_t& seed, const std::string& purpose) {
  command.add_option("--seed", seed, "Seed of " + purpose)->check(NotNegative());
}

CommandContext AddGroup(const CommandContext& context, const std::string& name,
                        const std::string& description, const std::string& examples) {
  CLI::App* group = context.app.add_subcommand(name, description);
  group->require_subcommand(1);
  group->footer("Examples:\n" + examples);
  return {*group, context.terminal, context.exit_code, context.command_line};
}

std::string CommandLine(std::span<char* const> words) {
  std::string line;
  for (const char* word : words) {
    if (!line.empty()) line += ' ';
    line += Quoted(word);
  }
  return line;
}

}  // namespace sweepstake::cli
