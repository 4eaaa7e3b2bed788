#include "server/config.h"

#include <toml++/toml.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "engine_client/text/names.h"
#include "server/storage/postgres/shared_store.h"

namespace sweepstake::server {
namespace {

// Collects error messages, one per line.
class Problems {
 public:
  void Add(const std::string& line) { lines_.push_back(line); }
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

// Returns whether the variable has the form of those that Kubernetes sets in containers for
// services whose names begin with "sweepstake".
bool IsFromKubernetes(const std::string& variable) {
  static const std::regex shape(
      "SWEEPSTAKE(_[A-Z0-9_]+)?_(SERVICE_HOST|SERVICE_PORT(_[A-Z0-9_]+)?|PORT|"
      "PORT_[0-9]+_(TCP|UDP|SCTP)(_(PROTO|PORT|ADDR))?)");
  return std::regex_match(variable, shape);
}

// Returns a scalar as text, or nothing for a table, an array or a date.
std::optional<std::string> ScalarText(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_integer()) return absl::StrCat(number->get());
  if (const auto* number = node.as_floating_point()) return nlohmann::json(number->get()).dump();
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  return std::nullopt;
}

// A value of a TOML file that is not a table.
struct Leaf {
  std::string key;
  const toml::node* node;
};

void AddLeaves(const toml::table& table, const std::string& prefix, std::vector<Leaf>& leaves) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const auto* inner = node.as_table()) {
      AddLeaves(*inner, key + ".", leaves);
    } else {
      leaves.push_back({key, &node});
    }
  }
}

absl::Status CheckAddress(const std::string& key, const std::string& address) {
  const size_t colon = address.rfind(':');
  const std::string port_text = colon == std::string::npos ? "" : address.substr(colon + 1);
  int port = -1;
  if (colon == 0 || port_text.find_first_not_of("0123456789") != std::string::npos ||
      !absl::SimpleAtoi(port_text, &port) || port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat(key, ": expected HOST:PORT with a port from 0 to 65535, not ", address));
  }
  const std::string host = address.substr(0, colon);
  if (host.find(':') != std::string::npos && !(host.starts_with('[') && host.ends_with(']'))) {
    return absl::InvalidArgumentError(absl::StrCat(key,
                                                   ": an IPv6 address needs brackets: expected [",
                                                   host, "]:", port_text, ", not ", address));
  }
  return absl::OkStatus();
}

void CheckTls(const tls::Files& files, Problems& problems) {
  if (files.cert.empty() != files.key.empty())
    problems.Add("tls_cert and tls_key go together: set both or neither");
  if (files.cert.empty() && !files.ca.empty())
    problems.Add("tls_client_ca needs TLS: set tls_cert and tls_key too");
}

void CheckHosts(const Config& config, Problems& problems) {
  static const std::regex shape("[A-Za-z0-9_.-]+|\\[[0-9A-Fa-f:.]+\\]");
  for (const std::string& host : HttpHosts(config)) {
    if (std::regex_match(host, shape)) continue;
    problems.Add(absl::StrCat("http_hosts: expected names without scheme and port, separated by ",
                              "commas, not ", host));
  }
}

// Returns whether other machines can reach the HTTP listener.
bool HttpIsOpen(const Config& config) {
  return !config.http.empty() && !tls::IsLoopback(config.http);
}

void CheckReach(const Config& config, Problems& problems) {
  if (!config.rpc.tls.cert.empty()) return;
  if (!config.insecure && !tls::IsLoopback(config.listen)) {
    problems.Add(absl::StrCat("listen: other machines can reach ", config.listen,
                              " and TLS is off; set --tls-cert and --tls-key, listen on "
                              "127.0.0.1, or allow plain text with --insecure"));
  }
  if (!config.http_plain && HttpIsOpen(config)) {
    problems.Add(absl::StrCat("http: other machines can reach ", config.http,
                              " and TLS is off; set --tls-cert and --tls-key, listen on "
                              "127.0.0.1, or allow plain text with --http-plain"));
  }
}

}  // namespace

std::string Settings::ValueOf(const Setting& setting) {
  return setting.option->capture_default_str()->get_default_str();
}

absl::Status Settings::Assign(std::string Setting::*name_of, const std::string& name,
                              const std::string& value) {
  const auto found = std::find_if(settings_.begin(), settings_.end(),
                                  [&](const Setting& each) { return each.*name_of == name; });
  if (found == settings_.end()) {
    std::vector<std::string_view> names;
    for (const Setting& setting : settings_) names.push_back(setting.*name_of);
    return absl::InvalidArgumentError(text::UnknownNameOfMany("setting", name, names));
  }
  absl::Status status;
  found->option->clear();  // drops the value of a flag, which a later Parse restores
  try {
    found->option->add_result(value);
    found->option->run_callback();
  } catch (const CLI::Error& error) {
    // CLI11's message begins with the name of the flag, which is replaced by the name in the file
    // or the environment.
    const std::string message = error.what();
    status = absl::InvalidArgumentError(name + message.substr(message.find(':')));
  }
  found->option->clear();
  return status;
}

absl::Status Settings::ReadFile(const std::filesystem::path& path) {
  std::error_code unknown;  // a file that cannot be examined is treated as missing
  if (!std::filesystem::exists(path, unknown))
    return absl::NotFoundError(absl::StrCat(path.string(), ": no such file"));
  // The parser would read a directory as an empty file.
  if (std::filesystem::is_directory(path, unknown))
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": is a directory, not a file"));
  toml::table table;
  try {
    table = toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ":", error.source().begin.line,
                                                   ": ", std::string(error.description())));
  }
  std::vector<Leaf> leaves;
  AddLeaves(table, "", leaves);
  Problems problems;
  for (const auto& [key, node] : leaves) {
    const std::optional<std::string> value = ScalarText(*node);
    problems.Add(
        value ? Assign(&Setting::key, key, *value)
              : absl::InvalidArgumentError(key + ": expected a string, a number, true or false"),
        absl::StrCat(path.string(), ":", node->source().begin.line, ": "));
  }
  return problems.Sum();
}

absl::Status Settings::ReadEnvironment(std::span<const std::string> environment) {
  Problems problems;
  for (const std::string& entry : environment) {
    const size_t equals = entry.find('=');
    const std::string name = entry.substr(0, equals);
    if (!name.starts_with("SWEEPSTAKE_") || equals == std::string::npos) continue;
    if (name.starts_with("SWEEPSTAKE_CLIENT_") || IsFromKubernetes(name)) continue;
    problems.Add(Assign(&Setting::variable, name, entry.substr(equals + 1)), "environment: ");
  }
  return problems.Sum();
}

absl::Status Validate(const Config& config) {
  Problems problems;
  Problems addresses;
  addresses.Add(CheckAddress("listen", config.listen));
  if (!config.http.empty()) addresses.Add(CheckAddress("http", config.http));
  problems.Add(addresses.Sum());
  CheckTls(config.rpc.tls, problems);
  // Skip the reachability check if an address does not parse.
  if (addresses.Sum().ok()) {
    CheckReach(config, problems);
    CheckHosts(config, problems);
  }
  if (config.http == config.listen && !config.listen.ends_with(":0"))
    problems.Add("http: listen has the same address; give each one its own port");
  if (config.database_bytes < 2 * config.audit.bytes)
    problems.Add("database_mb: it includes the audit log; set it to at least twice audit_mb");
  if (config.data.empty()) problems.Add("data: name a directory");
  if (!config.store.empty()) problems.Add(storage::CheckStoreUrl(config.store), "store: ");
  for (const std::string& problem :
       decision::Problems(config.rpc.decision, decision::ShippedPolicies()))
    problems.Add("decision: " + problem);
  return problems.Sum();
}

absl::Status CheckFiles(const Config& config) {
  namespace fs = std::filesystem;
  Problems problems;
  std::error_code unknown;  // a path that cannot be examined is treated as missing
  for (const auto& [key, path] :
       {std::pair("data", config.data), {"port_file", config.port_file}}) {
    const fs::path parent = path.parent_path();
    if (!parent.empty() && !fs::is_directory(parent, unknown)) {
      problems.Add(
          absl::StrCat(key, ": ", parent.string(), " is not a directory; create it first"));
    }
  }
  if (fs::exists(config.data, unknown) && !fs::is_directory(config.data, unknown)) {
    problems.Add(absl::StrCat("data: ", config.data.string(),
                              " is not a directory; name another one, or move it away"));
  }
  if (fs::is_directory(config.port_file, unknown)) {
    problems.Add(
        absl::StrCat("port_file: ", config.port_file.string(), " is a directory; name a file"));
  }
  for (const absl::Status& status : tls::Check(config.rpc.tls)) problems.Add(status);
  return problems.Sum();
}

absl::Status CheckConfigFile(const std::filesystem::path& path) {
  CLI::App app;
  Config config;
  Problems problems;
  problems.Add(Settings(app, config).ReadFile(path));
  problems.Add(Validate(config), path.string() + ": ");
  problems.Add(CheckFiles(config), path.string() + ": ");
  return problems.Sum();
}

bool NeedsToken(const Config& config) {
  return config.require_tokens || config.rpc.trusts_proxy ||
         (!config.insecure && config.rpc.tls.ca.empty() &&
          (!tls::IsLoopback(config.listen) || HttpIsOpen(config)));
}

tls::Files HttpTls(const Config& config) {
  if (config.http_plain || !HttpIsOpen(config)) return {};
  return {.cert = config.rpc.tls.cert, .key = config.rpc.tls.key, .ca = {}};
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

ChangedKeys ChangedSettings(Config before, Config after) {
  CLI::App app_before;
  CLI::App app_after;
  const Settings old(app_before, before);
  const Settings now(app_after, after);
  ChangedKeys keys;
  for (size_t i = 0; i < old.all().size(); ++i) {
    const Settings::Setting& setting = now.all()[i];
    if (Settings::ValueOf(old.all()[i]) != Settings::ValueOf(setting))
      (setting.is_live ? keys.live : keys.fixed).push_back(setting.key);
  }
  return keys;
}

std::string PrintConfig(Config config) {
  CLI::App app;
  std::string text;
  std::string section;
  const Settings settings(app, config);
  for (const Settings::Setting& setting : settings.all()) {
    const std::pair<std::string, std::string> parts = absl::StrSplit(setting.key, '.');
    const bool is_nested = !parts.second.empty();
    if (is_nested && parts.first != section) absl::StrAppend(&text, "\n[", parts.first, "]\n");
    if (is_nested) section = parts.first;
    const std::string help = setting.option->get_description();
    absl::StrAppend(&text, is_nested ? parts.second : parts.first, " = ",
                    Settings::ValueOf(setting), "  # ", help.substr(0, help.rfind(" [")), "\n");
  }
  return text;
}

}  // namespace sweepstake::server
