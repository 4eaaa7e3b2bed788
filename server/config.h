// The daemon's configuration: defaults, then a TOML file, then the environment, then flags; a later
// source overrides an earlier one.
//
// One table (config_settings.cc) names every setting once. Its names in the file
// (`decision.cooldown_ms`), in the environment (`SWEEPSTAKE_DECISION_COOLDOWN_MS`) and as a flag
// (`--decision-cooldown-ms`) follow from it. An unknown name is an error that says which one is
// nearest. Values are checked one by one, then together. All functions are pure but for
// those that read files.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rpc/common/options.h"
#include "server/sessions/audit_rows.h"

namespace sweepstake::server {

struct Config {
  std::string listen = "127.0.0.1:7433";  // HOST:PORT; port 0 means any free port
  std::string http;        // HOST:PORT of the dashboard, /metrics, /livez and /readyz; empty: none
  std::string http_hosts;  // further names of the daemon, separated by commas
  std::filesystem::path data = "sweepstake-data";
  std::string store;  // URL of the prior store that several daemons share; empty: one in `data`
  std::filesystem::path port_file;       // the ports are written to it once the daemon listens
  std::string log_level = "info";        // trace, debug, info, warn, error or off
  bool require_tokens = false;           // does not start without a token, wherever it listens
  bool insecure = false;                 // allows plain text on addresses other than loopback
  uint64_t database_bytes = 4ull << 30;  // priors.db does not grow beyond it
  priors::AuditLimits audit;             // of the rows of priors.db
  size_t backup_count = 3;               // automatic backups that are kept; 0 makes none
  uint32_t backup_hours = 24;            // from one to the next
  rpc::RpcOptions rpc;
};

// The names and properties of one setting.
struct SettingDescription {
  std::string key;       // name in the file
  std::string variable;  // name in the environment
  std::string flag;
  std::string help;
  bool is_switch = false;  // a flag without a value
};
std::vector<SettingDescription> DescribeSettings();

// The values that a source assigns, by key.
using Assignments = std::map<std::string, std::string>;

// Reads a TOML file. Errors: INVALID_ARGUMENT (says what is wrong, where, and what is valid; also a
// directory), NOT_FOUND (no such file).
absl::StatusOr<Assignments> ReadConfigFile(const std::filesystem::path& path);
// Reads NAME=VALUE strings. Names that do not begin with SWEEPSTAKE_ are ignored, and so are those
// of the command line (SWEEPSTAKE_CLIENT_…) and those that Kubernetes makes for a service of that
// name (SWEEPSTAKE_SERVICE_…, SWEEPSTAKE_PORT and SWEEPSTAKE_PORT_7433_…).
absl::StatusOr<Assignments> ReadEnvironment(std::span<const std::string> environment);

// Checks the words of a command line that set or clear a switch: it may be given a value, which is
// true or false (--insecure=false), its negation none, and both together are an error.
absl::Status CheckSwitches(std::span<const std::string> words);

// What messages call a setting: what its last source calls it. One that no source has assigned has
// its name as a flag where there are flags, else its key.
class SettingNames {
 public:
  void AddKeys(const Assignments& assignments);
  void AddVariables(const Assignments& assignments);
  void AddFlags(const Assignments& assignments);
  std::string Of(const std::string& key) const;

 private:
  std::map<std::string, std::string> names_;  // by key
  bool has_flags_ = false;
};

// The next four say all that is wrong in one status, a line for each.

// Sets the assigned values, but for wrong ones. `origin` is used in messages: "config.toml",
// "environment", "command line".
absl::Status Assign(const Assignments& assignments, std::string_view origin, Config& config,
                    const SettingNames& names = {});

// Checks the rules for several settings together: other addresses than loopback need TLS or
// --insecure, each listener has an address of its own, and the weights sum to 1. The files of TLS
// are not read.
absl::Status Validate(const Config& config, const SettingNames& names = {});
// Checks what the configuration names on this machine, and makes nothing: the files of TLS, which
// must belong together, the directories that `data` and `port_file` are to be made in, and what is
// there already in their place.
absl::Status CheckFiles(const Config& config);
// Does all three for a TOML file, whose name begins each line.
absl::Status CheckConfigFile(const std::filesystem::path& path);

// Returns whether the daemon must not start without a token: the configuration says so, or others
// can reach it, and neither clients' certificates nor --insecure say who may. REQUIRES: the
// configuration is valid.
bool NeedsToken(const Config& config);

// Returns the names, in lower case and without ports, that a browser may ask for the daemon by:
// those of http_hosts and that of `http`.
std::set<std::string, std::less<>> HttpHosts(const Config& config);

// The keys of settings that differ.
struct ChangedKeys {
  std::vector<std::string> live;   // a running daemon takes them over
  std::vector<std::string> fixed;  // need a restart
};
ChangedKeys ChangedSettings(const Config& before, const Config& after);

// Returns every setting with its value, as a TOML file that ReadConfigFile can read.
std::string PrintConfig(const Config& config);

}  // namespace sweepstake::server
