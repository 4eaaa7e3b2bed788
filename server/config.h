// The daemon's configuration: defaults, a TOML file, the environment and flags. A later source
// overrides an earlier one.
//
// One table (config_settings.cc) defines every setting as an option of CLI11, with its help, type,
// bounds and default. The names in the file (`decision.cooldown_ms`), in the environment
// (`SWEEPSTAKE_DECISION_COOLDOWN_MS`) and on the command line (`--decision-cooldown-ms`) follow
// from one another. An unknown name is an error that lists the nearest valid ones.
#pragma once

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/history/history_file.h"
#include "server/rpc/common/options.h"
#include "server/sessions/audit_rows.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sweepstake::server {

struct Config {
  std::string listen = "127.0.0.1:7433";  // HOST:PORT; port 0 means any free port
  std::string http;        // HOST:PORT of the dashboard, /metrics, /livez and /readyz; empty: none
  std::string http_hosts;  // further names of the daemon, separated by commas
  std::string http_base;   // path under which a proxy serves `http`, such as /sweepstake; or empty
  std::filesystem::path data = "sweepstake-data";
  std::string store;  // URL of the prior store that several daemons share; empty: one in `data`
  std::filesystem::path port_file;  // the ports are written to it once the daemon listens
  std::string log_level = "info";   // trace, debug, info, warn, error or off
  bool require_tokens = false;      // refuses to start without a token, on every address
  bool insecure = false;    // gRPC: allows plain text without tokens on addresses besides loopback
  bool http_plain = false;  // HTTP: allows plain text on addresses besides loopback
  uint64_t database_bytes = 4ull << 30;  // maximum size of priors.db
  priors::AuditLimits audit;             // limits of the audit log in priors.db
  size_t backup_count = 3;               // automatic backups that are kept; 0 makes none
  uint32_t backup_hours = 24;            // time between two backups
  history::HistoryLimits history;        // limits of history.db
  std::string webhook;                   // URL that receives alerts as JSON; empty: none
  rpc::RpcOptions rpc;
};

// The settings of one Config as options of a CLI11 application. Parsing a command line with the
// application assigns the flags. ReadFile and ReadEnvironment assign the values of the other
// sources. Not thread-safe.
class Settings {
 public:
  struct Setting {
    std::string key;       // name in the file
    std::string variable;  // name in the environment
    CLI::Option* option;
    bool is_live;  // SIGHUP reloads it
  };

  // Adds an option for each setting. `app` and `config` must outlive this object.
  Settings(CLI::App& app, Config& config);

  // Assigns the settings of a TOML file. Errors: INVALID_ARGUMENT (all problems, one per line, each
  // with file and line; the correct settings are assigned), NOT_FOUND (no such file).
  absl::Status ReadFile(const std::filesystem::path& path);
  // Assigns the settings in NAME=VALUE strings whose name begins with SWEEPSTAKE_. Ignores the
  // variables of the command line (SWEEPSTAKE_CLIENT_…) and those that Kubernetes sets for a
  // service (SWEEPSTAKE_SERVICE_…, SWEEPSTAKE_PORT_7433_…). Error: INVALID_ARGUMENT (all problems,
  // one per line; the correct settings are assigned).
  absl::Status ReadEnvironment(std::span<const std::string> environment);

  const std::vector<Setting>& all() const { return settings_; }
  // Returns a setting's value in the Config, as TOML.
  static std::string ValueOf(const Setting& setting);

 private:
  // Assigns the value to the setting called `name`. `name_of` is the member with that name:
  // Setting::key or Setting::variable.
  absl::Status Assign(std::string Setting::*name_of, const std::string& name,
                      const std::string& value);

  std::vector<Setting> settings_;  // in the order of --print-config
};

// Checks the rules that concern several settings: addresses other than loopback need TLS,
// `insecure` (gRPC) or `http_plain` (HTTP), each listener has its own address, and the weights sum
// to 1. Does not read files. All problems are reported, one per line, also by the next two
// functions.
absl::Status Validate(const Config& config);
// Checks the files that the configuration names, and creates none: the TLS files must be readable
// and belong together, the parents of `data` and `port_file` must exist, `data` must not be a file,
// and `port_file` must not be a directory.
absl::Status CheckFiles(const Config& config);
// Reads a TOML file and makes all checks. Each line begins with the name of the file.
absl::Status CheckConfigFile(const std::filesystem::path& path);

// Returns whether the daemon refuses to start without a token: `require_tokens` or `trusted_proxy`
// is set, or other machines can connect and neither client certificates nor `insecure` admit them.
// REQUIRES: the configuration is valid.
bool NeedsToken(const Config& config);

// Returns the TLS files of the HTTP listener: those of gRPC without the clients' authority. Empty
// if it uses plain text, on a loopback address or because of `http_plain`.
tls::Files HttpTls(const Config& config);

// Returns the host names that a browser may use for the daemon, in lower case and without ports:
// those of http_hosts and the host of `http`.
std::set<std::string, std::less<>> HttpHosts(const Config& config);

// The keys of settings that differ between two configurations.
struct ChangedKeys {
  std::vector<std::string> live;   // a running daemon applies them
  std::vector<std::string> fixed;  // need a restart
};
ChangedKeys ChangedSettings(Config before, Config after);

// Returns every setting with its value, as a TOML file that Settings::ReadFile can read.
std::string PrintConfig(Config config);

}  // namespace sweepstake::server
