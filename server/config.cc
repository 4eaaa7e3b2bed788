#include "server/config.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <regex>
#include <system_error>
#include <utility>

#include <toml++/toml.h>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/decision/math/names.h"
#include "server/decision/session/session_setup.h"

namespace sweepstake::server {
namespace {

constexpr std::string_view kVariablePrefix = "SWEEPSTAKE_";
constexpr std::string_view kClientPrefix = "SWEEPSTAKE_CLIENT_";  // of the command line's variables
constexpr int64_t kNsPerMs = 1'000'000;

// Reads a value into the configuration. The error says which values are valid.
using Setter = std::function<absl::Status(Config&, const std::string&)>;
// Returns the value as TOML.
using Getter = std::function<std::string(const Config&)>;

struct Setting {
  std::string key;
  std::string help;
  Setter set;
  Getter get;
  bool is_switch = false;
};

absl::Status Expected(absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("expected ", what));
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += absl::StrFormat("\\u%04X", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

template <typename T>
bool ParseNumber(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

// Returns the shortest text that reads back as the same number.
std::string ShortestText(double number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

template <typename Field>
Setting Text(std::string key, Field field, std::string help) {
  return {std::move(key), std::move(help),
          [field](Config& config, const std::string& value) {
            field(config) = value;
            return absl::OkStatus();
          },
          [field](const Config& config) {
            Config copy = config;
            return Quoted(std::filesystem::path(field(copy)).string());
          }};
}

template <typename Field>
Setting Switch(std::string key, Field field, std::string help) {
  return {std::move(key), std::move(help),
          [field](Config& config, const std::string& value) {
            if (value != "true" && value != "false") return Expected("true or false");
            field(config) = value == "true";
            return absl::OkStatus();
          },
          [field](const Config& config) {
            Config copy = config;
            return std::string(field(copy) ? "true" : "false");
          },
          /*is_switch=*/true};
}

template <typename Field>
Setting Real(std::string key, Field field, std::string help) {
  return {std::move(key), std::move(help),
          [field](Config& config, const std::string& value) {
            double number = 0;
            if (!ParseNumber(value, number) || !std::isfinite(number))
              return Expected("a finite number");
            field(config) = number;
            return absl::OkStatus();
          },
          [field](const Config& config) {
            Config copy = config;
            std::string number = ShortestText(field(copy));
            // A TOML float has a point or an exponent.
            return number.find_first_of(".e") == std::string::npos ? number + ".0" : number;
          }};
}

// Makes the setting of a whole number from `min` to `max`, which is stored in multiples of `unit`.
template <typename Field>
Setting Whole(std::string key, int64_t min, int64_t max, int64_t unit, Field field,
              std::string help) {
  return {std::move(key), std::move(help),
          [field, min, max, unit](Config& config, const std::string& value) {
            int64_t number = 0;
            if (!ParseNumber(value, number) || number < min || number > max) {
              return Expected(absl::StrCat("a whole number from ", min, " to ", max));
            }
            auto& target = field(config);
            target = static_cast<std::remove_reference_t<decltype(target)>>(number * unit);
            return absl::OkStatus();
          },
          [field, unit](const Config& config) {
            Config copy = config;
            return std::to_string(static_cast<int64_t>(field(copy)) / unit);
          }};
}

absl::Status SetLogLevel(Config& config, const std::string& value) {
  static constexpr std::string_view kLevels[] = {"trace", "debug", "info", "warn", "error", "off"};
  if (std::find(std::begin(kLevels), std::end(kLevels), value) == std::end(kLevels)) {
    return Expected("one of trace, debug, info, warn, error, off");
  }
  config.log_level = value;
  return absl::OkStatus();
}

constexpr int64_t kYearMs = 31'536'000'000;

std::vector<Setting> DaemonSettings() {
  return {
      Text(
          "listen", [](Config & c) -> auto& { return c.listen; },
          "HOST:PORT to serve gRPC on; port 0 takes a free one"),
      Text(
          "http", [](Config & c) -> auto& { return c.http; },
          "HOST:PORT to serve /metrics, /livez and /readyz on; empty serves none"),
      Text(
          "data", [](Config & c) -> auto& { return c.data; },
          "directory of the prior store; made if it is missing"),
      Text(
          "port_file", [](Config & c) -> auto& { return c.port_file; },
          "file that gets the gRPC port once it listens, and the HTTP port in its second line"),
      {"log_level", "trace, debug, info, warn, error or off", SetLogLevel,
       [](const Config& c) { return Quoted(c.log_level); }},
      Switch(
          "insecure", [](Config & c) -> auto& { return c.insecure; },
          "allow plain text on addresses that others can reach"),
      Text(
          "tls_cert", [](Config & c) -> auto& { return c.rpc.tls.cert; },
          "PEM file of the certificate to serve TLS with, its issuers' after it; read every "
          "second"),
      Text(
          "tls_key", [](Config & c) -> auto& { return c.rpc.tls.key; },
          "PEM file of the certificate's private key"),
      Text(
          "tls_client_ca", [](Config & c) -> auto& { return c.rpc.tls.ca; },
          "PEM file of the authorities that must have signed the client's certificate"),
      Switch(
          "reflection", [](Config & c) -> auto& { return c.rpc.reflection; },
          "serve gRPC reflection, for grpcurl and the like"),
      Whole(
          "max_time_scale", 1, static_cast<int64_t>(rpc::kMaxTimeScale), 1,
          [](Config & c) -> auto& { return c.rpc.max_time_scale; },
          "largest time scale that a game may ask for, up to 1000; for experiments: such a game "
          "learns and commits that many times as often"),
      Whole(
          "max_sessions", 1, 1'000'000, 1, [](Config & c) -> auto& { return c.rpc.max_sessions; },
          "sessions in memory, connected or resumable"),
      Whole(
          "max_watchers", 1, 100'000, 1, [](Config & c) -> auto& { return c.rpc.max_watchers; },
          "watchers at a time"),
      Whole(
          "resume_window_ms", 0, kYearMs, kNsPerMs,
          [](Config & c) -> auto& { return c.rpc.resume_window_ns; },
          "how long a lost session stays in memory"),
      Whole(
          "memory_quota_mb", 8, 1 << 20, 1 << 20,
          [](Config & c) -> auto& { return c.rpc.memory_quota_bytes; },
          "memory of all connections' buffers"),
      Whole(
          "database_mb", 8, 1 << 24, 1 << 20, [](Config & c) -> auto& { return c.database_bytes; },
          "size of priors.db; beyond it nothing more is stored or acknowledged"),
      Whole(
          "audit_mb", 0, 1 << 20, 1 << 20, [](Config & c) -> auto& { return c.rpc.audit.bytes; },
          "text of the audit log; beyond it the oldest rows go; 0 keeps none"),
      Whole(
          "audit_days", 1, 36'500, 86'400, [](Config & c) -> auto& { return c.rpc.audit.age_s; },
          "age at which rows of the audit log go"),
  };
}

template <typename Field>
Setting Interval(std::string key, Field field, std::string help) {
  return Whole(std::move(key), 0, kYearMs, kNsPerMs, field, std::move(help));
}

std::vector<Setting> DecisionSettings() {
  return {
      Text(
          "decision.policy", [](Config & c) -> auto& { return c.rpc.decision.policy; },
          "policy of sessions that name none"),
      Real(
          "decision.weight_fps", [](Config & c) -> auto& { return c.rpc.decision.weights.fps; },
          "weight of the FPS score"),
      Real(
          "decision.weight_detection",
          [](Config & c) -> auto& { return c.rpc.decision.weights.detection; },
          "weight of the detection time's score"),
      Real(
          "decision.weight_memory",
          [](Config & c) -> auto& { return c.rpc.decision.weights.memory; },
          "weight of the memory's score"),
      Real(
          "decision.weight_checks",
          [](Config & c) -> auto& { return c.rpc.decision.weights.checks; },
          "weight of the AABB checks' score"),
      Interval(
          "decision.interval_ms",
          [](Config & c) -> auto& { return c.rpc.decision.decision_interval_ns; },
          "time between decisions"),
      Interval(
          "decision.cooldown_ms", [](Config & c) -> auto& { return c.rpc.decision.cooldown_ns; },
          "min time between two switches"),
      Interval(
          "decision.settling_ms", [](Config & c) -> auto& { return c.rpc.decision.settling_ns; },
          "frame time after a switch that is not learnt from"),
      Interval(
          "decision.bail_out_ms", [](Config & c) -> auto& { return c.rpc.decision.bail_out_ns; },
          "a longer frame is a bail-out"),
      Interval(
          "decision.exploration_warm_up_ms",
          [](Config & c) -> auto& { return c.rpc.decision.exploration_warm_up_ns; },
          "warm-up per arm at the start"),
      Interval(
          "decision.exploration_measure_ms",
          [](Config & c) -> auto& { return c.rpc.decision.exploration_measure_ns; },
          "measured time per arm at the start"),
      Switch(
          "decision.explore", [](Config & c) -> auto& { return c.rpc.decision.explore; },
          "try every arm once at the start"),
      Real(
          "decision.bail_out_penalty",
          [](Config & c) -> auto& { return c.rpc.decision.bail_out_penalty; },
          "zero-reward observations that a bail-out counts as"),
      Real(
          "decision.fps_floor", [](Config & c) -> auto& { return c.rpc.decision.fps_floor; },
          "frames/s below which even the best arm is a degraded scene"),
  };
}

std::vector<Setting> Settings() {
  std::vector<Setting> settings = DaemonSettings();
  for (Setting& setting : DecisionSettings()) settings.push_back(std::move(setting));
  return settings;
}

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
  return absl::InvalidArgumentError(math::UnknownName(what, name, names));
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

absl::Status Flatten(const toml::table& table, const std::string& prefix,
                     Assignments& assignments) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const auto* inner = node.as_table()) {
      if (absl::Status status = Flatten(*inner, key + ".", assignments); !status.ok())
        return status;
    } else if (std::optional<std::string> value = ScalarText(node)) {
      assignments[key] = *std::move(value);
    } else {
      return absl::InvalidArgumentError(
          absl::StrCat(key, ": expected a text, a number, true or false"));
    }
  }
  return absl::OkStatus();
}

bool IsLoopback(const std::string& listen) {
  const std::string host = listen.substr(0, listen.rfind(':'));
  // Other names are not resolved, so only numeric addresses and localhost count.
  in_addr address{};
  const bool is_number = inet_pton(AF_INET, host.c_str(), &address) == 1;
  return host == "localhost" || host == "[::1]" ||
         (is_number && ntohl(address.s_addr) >> 24 == 127);
}

// Checks a listener's address. `key` is its setting.
absl::Status CheckListen(std::string_view key, const std::string& listen) {
  const size_t colon = listen.rfind(':');
  int port = -1;
  if (colon == std::string::npos || colon == 0 || !ParseNumber(listen.substr(colon + 1), port) ||
      port < 0 || port > 65535) {
    return absl::InvalidArgumentError(absl::StrCat(
        std::string(key), ": expected HOST:PORT with a port from 0 to 65535, not ", listen));
  }
  return absl::OkStatus();
}

absl::Status CheckTls(const tls::Files& files) {
  if (files.cert.empty() != files.key.empty()) {
    return absl::InvalidArgumentError("tls_cert and tls_key go together: name both, or neither");
  }
  if (files.cert.empty() && !files.ca.empty()) {
    return absl::InvalidArgumentError("tls_client_ca needs TLS: name tls_cert and tls_key, too");
  }
  return absl::OkStatus();
}

}  // namespace

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
  toml::table table;
  try {
    table = toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ":", error.source().begin.line,
                                                   ": ", std::string(error.description())));
  }
  Assignments assignments;
  if (absl::Status status = Flatten(table, "", assignments); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": ", status.message()));
  }
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

absl::Status Assign(const Assignments& assignments, std::string_view origin, Config& config) {
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
    const std::string what = found == keys.end() ? "" : absl::StrCat(key, ": ");
    return absl::InvalidArgumentError(
        absl::StrCat(std::string(origin), ": ", what, status.message(),
                     found == keys.end() ? "" : absl::StrCat(", not ", value)));
  }
  return absl::OkStatus();
}

absl::Status Validate(const Config& config) {
  const tls::Files& tls = config.rpc.tls;
  absl::Status status = CheckListen("listen", config.listen);
  if (status.ok() && !config.http.empty()) status = CheckListen("http", config.http);
  if (status.ok()) status = CheckTls(tls);
  if (!status.ok()) return status;
  if (!config.insecure && tls.cert.empty() && !IsLoopback(config.listen)) {
    return absl::InvalidArgumentError(
        absl::StrCat("listen: ", config.listen,
                     " can be reached by others, and there is no TLS; name --tls-cert and "
                     "--tls-key, listen on 127.0.0.1, or say --insecure"));
  }
  if (config.database_bytes < 2 * config.rpc.audit.bytes) {
    return absl::InvalidArgumentError(
        "database_mb: the audit log is a part of it; allow at least twice audit_mb");
  }
  if (!config.insecure && !config.http.empty() && !IsLoopback(config.http)) {
    return absl::InvalidArgumentError(
        absl::StrCat("http: ", config.http,
                     " can be reached by others, and HTTP is plain text; listen on 127.0.0.1, or "
                     "say --insecure"));
  }
  if (config.data.empty()) return absl::InvalidArgumentError("data: name a directory");
  if (const auto problem = decision::Validate(config.rpc.decision)) {
    return absl::InvalidArgumentError(absl::StrCat("decision: ", *problem));
  }
  return absl::OkStatus();
}

std::vector<std::string> ChangedSettings(const Config& before, const Config& after) {
  std::vector<std::string> keys;
  for (const Setting& setting : Settings()) {
    if (setting.get(before) != setting.get(after)) keys.push_back(setting.key);
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
