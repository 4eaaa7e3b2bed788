#include "server/config.h"

#include <algorithm>
#include <optional>
#include <regex>
#include <system_error>
#include <utility>

#include <toml++/toml.h>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/telemetry/tls/loopback.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "engine_client/text/names.h"
#include "server/config_settings.h"
#include "server/storage/postgres/shared_store.h"

namespace sweepstake::server {
namespace {

constexpr std::string_view kVariablePrefix = "SWEEPSTAKE_";
constexpr std::string_view kClientPrefix = "SWEEPSTAKE_CLIENT_";  // of the command line's variables

std::string VariableOf(const std::string& key) {
  std::string variable(kVariablePrefix);
  for (const char c : key)
    variable += c == '.' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return variable;
}

std::string FlagOf(const std::string& key) {
  std::string flag = "--";
  for (const char c : key) flag += c == '.' || c == '_' ? '-' : c;
  return flag;
}

absl::Status UnknownName(std::string_view what, std::string_view name,
                         std::span<const std::string> known) {
  const std::vector<std::string_view> names(known.begin(), known.end());
  return absl::InvalidArgumentError(text::UnknownNameOfMany(what, name, names));
}

// Returns whether Kubernetes sets such a variable in every container beside a service whose name
// begins with "sweepstake".
bool IsOfKubernetes(const std::string& variable) {
  static const std::regex shape(
      "SWEEPSTAKE(_[A-Z0-9_]+)?_(SERVICE_HOST|SERVICE_PORT(_[A-Z0-9_]+)?|PORT|"
      "PORT_[0-9]+_(TCP|UDP|SCTP)(_(PROTO|PORT|ADDR))?)");
  return std::regex_match(variable, shape);
}

// Returns a scalar as text, or nothing for a table or an array.
std::optional<std::string> ScalarText(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_integer()) return std::to_string(number->get());
  if (const auto* number = node.as_floating_point()) return ShortestText(number->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  return std::nullopt;
}

// All that is wrong, a line for each.
class Problems {
 public:
  void Add(const std::string& line) { lines_.push_back(line); }
  // Adds the lines of the status, each behind the prefix.
  void Add(const absl::Status& status, const std::string& prefix = "") {
    if (status.ok()) return;
    for (const absl::string_view line : absl::StrSplit(status.message(), '\n'))
      lines_.push_back(absl::StrCat(prefix, line));
  }
  absl::Status Sum() const {
    if (lines_.empty()) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrJoin(lines_, "\n"));
  }

 private:
  std::vector<std::string> lines_;
};

void Flatten(const toml::table& table, const std::string& prefix, Assignments& assignments,
             Problems& problems) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const auto* inner = node.as_table()) {
      Flatten(*inner, key + ".", assignments, problems);
    } else if (std::optional<std::string> value = ScalarText(node)) {
      assignments[key] = *std::move(value);
    } else {
      problems.Add(absl::StrCat(key, ": expected a text, a number, true or false"));
    }
  }
}

// Checks a listener's address. `name` is its setting's.
absl::Status CheckListen(const std::string& name, const std::string& listen) {
  const size_t colon = listen.rfind(':');
  int port = -1;
  if (colon == std::string::npos || colon == 0 || !ParseNumber(listen.substr(colon + 1), port) ||
      port < 0 || port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": expected HOST:PORT with a port from 0 to 65535, not ", listen));
  }
  const std::string host = listen.substr(0, colon);
  if (host.find(':') != std::string::npos && !(host.starts_with('[') && host.ends_with(']'))) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": an IPv6 address stands in brackets: expected [", host, "]",
                     listen.substr(colon), ", not ", listen));
  }
  return absl::OkStatus();
}

void CheckTls(const tls::Files& files, const SettingNames& names, Problems& problems) {
  const std::string cert = names.Of("tls_cert");
  const std::string key = names.Of("tls_key");
  if (files.cert.empty() != files.key.empty())
    problems.Add(absl::StrCat(cert, " and ", key, " go together: name both, or neither"));
  if (files.cert.empty() && !files.ca.empty()) {
    problems.Add(
        absl::StrCat(names.Of("tls_client_ca"), " needs TLS: name ", cert, " and ", key, ", too"));
  }
}

void CheckHosts(const Config& config, const SettingNames& names, Problems& problems) {
  static const std::regex shape("[A-Za-z0-9_.-]+|\\[[0-9A-Fa-f:.]+\\]");
  for (const std::string& host : HttpHosts(config)) {
    if (std::regex_match(host, shape)) continue;
    problems.Add(absl::StrCat(names.Of("http_hosts"),
                              ": expected names without scheme and port, separated by commas, not ",
                              host));
  }
}

void CheckReach(const Config& config, const SettingNames& names, Problems& problems) {
  if (config.insecure) return;
  if (config.rpc.tls.cert.empty() && !tls::IsLoopback(config.listen)) {
    problems.Add(absl::StrCat(names.Of("listen"), ": ", config.listen,
                              " can be reached by others, and there is no TLS; name --tls-cert and "
                              "--tls-key, listen on 127.0.0.1, or say --insecure"));
  }
  if (!config.http.empty() && !tls::IsLoopback(config.http)) {
    problems.Add(absl::StrCat(names.Of("http"), ": ", config.http,
                              " can be reached by others, and HTTP is plain text; listen on "
                              "127.0.0.1, or say --insecure"));
  }
}

}  // namespace

void SettingNames::AddKeys(const Assignments& assignments) {
  for (const auto& [key, value] : assignments) names_[key] = key;
}

void SettingNames::AddVariables(const Assignments& assignments) {
  for (const auto& [key, value] : assignments) names_[key] = VariableOf(key);
}

void SettingNames::AddFlags(const Assignments& assignments) {
  for (const auto& [key, value] : assignments) names_[key] = FlagOf(key);
  has_flags_ = has_flags_ || !assignments.empty();
}

std::string SettingNames::Of(const std::string& key) const {
  if (const auto found = names_.find(key); found != names_.end()) return found->second;
  return has_flags_ ? FlagOf(key) : key;
}

std::vector<SettingDescription> DescribeSettings() {
  std::vector<SettingDescription> descriptions;
  for (const Setting& setting : Settings()) {
    descriptions.push_back({setting.key, VariableOf(setting.key), FlagOf(setting.key), setting.help,
                            setting.is_switch});
  }
  return descriptions;
}

absl::StatusOr<Assignments> ReadConfigFile(const std::filesystem::path& path) {
  std::error_code unknown;  // a file that cannot be examined is treated as missing
  if (!std::filesystem::exists(path, unknown))
    return absl::NotFoundError(absl::StrCat(path.string(), ": no such file"));
  // The parser would read it as an empty file.
  if (std::filesystem::is_directory(path, unknown))
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": is a directory, not a file"));
  toml::table table;
  try {
    table = toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ":", error.source().begin.line,
                                                   ": ", std::string(error.description())));
  }
  Assignments assignments;
  Problems found;
  Flatten(table, "", assignments, found);
  Problems problems;
  problems.Add(found.Sum(), path.string() + ": ");
  if (absl::Status status = problems.Sum(); !status.ok()) return status;
  return assignments;
}

absl::StatusOr<Assignments> ReadEnvironment(std::span<const std::string> environment) {
  std::map<std::string, std::string> keys;
  std::vector<std::string> variables;
  for (const Setting& setting : Settings()) {
    variables.push_back(VariableOf(setting.key));
    keys[variables.back()] = setting.key;
  }
  Assignments assignments;
  for (const std::string& entry : environment) {
    const size_t equals = entry.find('=');
    if (!entry.starts_with(kVariablePrefix) || equals == std::string::npos) continue;
    const std::string name = entry.substr(0, equals);
    if (const auto found = keys.find(name); found != keys.end()) {
      assignments[found->second] = entry.substr(equals + 1);
    } else if (!name.starts_with(kClientPrefix) && !IsOfKubernetes(name)) {
      return UnknownName("environment variable", name, variables);
    }
  }
  return assignments;
}

absl::Status CheckSwitches(std::span<const std::string> words) {
  for (const Setting& setting : Settings()) {
    if (!setting.is_switch) continue;
    const std::string flag = FlagOf(setting.key);
    const std::string negation = absl::StrCat("--no-", flag.substr(2));
    bool is_set = false;
    bool is_cleared = false;
    for (const std::string& word : words) {
      const bool has_value = word.starts_with(flag + "=");
      const std::string value = has_value ? word.substr(flag.size() + 1) : "";
      if (has_value && value != "true" && value != "false") {
        return absl::InvalidArgumentError(
            absl::StrCat("command line: ", flag, ": expected true or false, not '", value, "'"));
      }
      if (word.starts_with(negation + "=")) {
        return absl::InvalidArgumentError(absl::StrCat("command line: ", negation,
                                                       " takes no value; say ", flag, "=true or ",
                                                       flag, "=false"));
      }
      is_set = is_set || word == flag || value == "true";
      is_cleared = is_cleared || word == negation || value == "false";
    }
    if (is_set && is_cleared) {
      return absl::InvalidArgumentError(
          absl::StrCat("command line: ", flag, " is both set and cleared; say one of them"));
    }
  }
  return absl::OkStatus();
}

absl::Status Assign(const Assignments& assignments, std::string_view origin, Config& config,
                    const SettingNames& names) {
  Problems problems;
  const std::vector<Setting> settings = Settings();
  std::vector<std::string> keys;
  keys.reserve(settings.size());
  for (const Setting& setting : settings) keys.push_back(setting.key);
  for (const auto& [key, value] : assignments) {
    const auto found = std::find(keys.begin(), keys.end(), key);
    absl::Status status =
        found == keys.end()
            ? UnknownName("setting", key, keys)
            : settings[static_cast<size_t>(found - keys.begin())].set(config, value);
    if (status.ok()) continue;
    const std::string what = found == keys.end() ? "" : absl::StrCat(names.Of(key), ": ");
    problems.Add(absl::StrCat(std::string(origin), ": ", what, status.message(),
                              found == keys.end() ? "" : absl::StrCat(", not ", value)));
  }
  return problems.Sum();
}

absl::Status Validate(const Config& config, const SettingNames& names) {
  Problems problems;
  Problems listeners;
  listeners.Add(CheckListen(names.Of("listen"), config.listen));
  if (!config.http.empty()) listeners.Add(CheckListen(names.Of("http"), config.http));
  problems.Add(listeners.Sum());
  CheckTls(config.rpc.tls, names, problems);
  // Of an address that is none nobody can say who reaches it.
  if (listeners.Sum().ok()) {
    CheckReach(config, names, problems);
    CheckHosts(config, names, problems);
  }
  if (config.http == config.listen && !config.listen.ends_with(":0")) {
    problems.Add(absl::StrCat(names.Of("http"), ": ", config.http, " is that of ",
                              names.Of("listen"), ", too; give it a port of its own"));
  }
  if (config.database_bytes < 2 * config.audit.bytes) {
    problems.Add(absl::StrCat(names.Of("database_mb"),
                              ": the audit log is a part of it; allow at least twice ",
                              names.Of("audit_mb")));
  }
  if (config.data.empty()) problems.Add(names.Of("data") + ": name a directory");
  if (!config.store.empty()) {
    const absl::Status status = storage::CheckStoreUrl(config.store);
    if (!status.ok()) problems.Add(absl::StrCat(names.Of("store"), ": ", status.message()));
  }
  for (const std::string& problem :
       decision::Problems(config.rpc.decision, decision::ShippedPolicies()))
    problems.Add(absl::StrCat("decision: ", problem));
  return problems.Sum();
}

absl::Status CheckFiles(const Config& config) {
  Problems problems;
  const std::pair<std::string_view, const std::filesystem::path&> made[] = {
      {"data", config.data}, {"port_file", config.port_file}};
  for (const auto& [key, path] : made) {
    std::error_code unknown;  // what cannot be examined is treated as missing
    const std::filesystem::path parent = path.parent_path();
    if (!parent.empty() && !std::filesystem::is_directory(parent, unknown)) {
      problems.Add(
          absl::StrCat(std::string(key), ": ", parent.string(), " is no directory; make it first"));
    }
  }
  std::error_code unknown;
  if (std::filesystem::exists(config.data, unknown) &&
      !std::filesystem::is_directory(config.data, unknown)) {
    problems.Add(absl::StrCat("data: ", config.data.string(),
                              " is no directory; name another, or move it away"));
  }
  if (std::filesystem::is_directory(config.port_file, unknown)) {
    problems.Add(
        absl::StrCat("port_file: ", config.port_file.string(), " is a directory; name a file"));
  }
  for (const absl::Status& status : tls::Check(config.rpc.tls)) problems.Add(status);
  return problems.Sum();
}

absl::Status CheckConfigFile(const std::filesystem::path& path) {
  const auto assignments = ReadConfigFile(path);
  if (!assignments.ok()) return assignments.status();
  Config config;
  Problems problems;
  problems.Add(Assign(*assignments, path.string(), config));
  problems.Add(Validate(config), path.string() + ": ");
  problems.Add(CheckFiles(config), path.string() + ": ");
  return problems.Sum();
}

bool NeedsToken(const Config& config) {
  return config.require_tokens ||
         (!config.insecure && config.rpc.tls.ca.empty() && !tls::IsLoopback(config.listen));
}

std::set<std::string, std::less<>> HttpHosts(const Config& config) {
  std::set<std::string, std::less<>> hosts;
  for (const absl::string_view name :
       absl::StrSplit(config.http_hosts, ',', absl::SkipWhitespace()))
    hosts.insert(absl::AsciiStrToLower(absl::StripAsciiWhitespace(name)));
  if (!config.http.empty())
    hosts.insert(absl::AsciiStrToLower(config.http.substr(0, config.http.rfind(':'))));
  return hosts;
}

ChangedKeys ChangedSettings(const Config& before, const Config& after) {
  ChangedKeys keys;
  for (const Setting& setting : Settings()) {
    if (setting.get(before) != setting.get(after))
      (setting.is_live ? keys.live : keys.fixed).push_back(setting.key);
  }
  return keys;
}

std::string PrintConfig(const Config& config) {
  std::string text;
  std::string section;
  for (const Setting& setting : Settings()) {
    const size_t dot = setting.key.find('.');
    const std::string wanted = dot == std::string::npos ? "" : setting.key.substr(0, dot);
    if (wanted != section) absl::StrAppend(&text, "\n[", wanted, "]\n");
    section = wanted;
    absl::StrAppend(&text, dot == std::string::npos ? setting.key : setting.key.substr(dot + 1),
                    " = ", setting.get(config), "  # ", setting.help, "\n");
  }
  return text;
}

}  // namespace sweepstake::server
