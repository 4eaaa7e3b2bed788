#include "server/config_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/text/names.h"

namespace sweepstake::server {
namespace {

constexpr int64_t kNsPerMs = 1'000'000;

absl::Status Expected(absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("expected ", what));
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

template <typename Field>
Setting Text(std::string key, Field field, std::string help) {
  return {std::move(key), std::move(help),
          [field](Config& config, const std::string& value) {
            if (!text::IsLine(value)) return Expected("UTF-8 without control characters");
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

// Marks a setting that a running daemon takes over at SIGHUP.
Setting Live(Setting setting) {
  setting.is_live = true;
  setting.help += "; taken over at SIGHUP";
  return setting;
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
          "HOST:PORT to serve the dashboard, /metrics, /livez and /readyz on; empty serves none"),
      Text(
          "http_hosts", [](Config & c) -> auto& { return c.http_hosts; },
          "names, separated by commas, that browsers may ask for the dashboard by, beside its "
          "address: that of a proxy in front"),
      Text(
          "data", [](Config & c) -> auto& { return c.data; },
          "directory of the prior store; made if it is missing"),
      Text(
          "store", [](Config & c) -> auto& { return c.store; },
          "postgresql:// URL, without a password, of a prior store that several daemons share; "
          "empty: priors.db in `data`"),
      Text(
          "port_file", [](Config & c) -> auto& { return c.port_file; },
          "file that gets the gRPC port once it listens, and the HTTP port in its second line"),
      Live({"log_level", "trace, debug, info, warn, error or off", SetLogLevel,
            [](const Config& c) { return Quoted(c.log_level); }}),
      Switch(
          "require_tokens", [](Config & c) -> auto& { return c.require_tokens; },
          "start with a token only, wherever it listens: for instance behind a proxy"),
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
      Live(Whole(
          "max_time_scale", 1, static_cast<int64_t>(rpc::kMaxTimeScale), 1,
          [](Config & c) -> auto& { return c.rpc.max_time_scale; },
          "largest time scale that a game may ask for, up to 1000; for experiments: such a game "
          "learns and commits that many times as often")),
      Live(Whole(
          "max_sessions", 1, 1'000'000, 1, [](Config & c) -> auto& { return c.rpc.max_sessions; },
          "sessions in memory, connected or resumable")),
      Live(Whole(
          "max_sessions_per_token", 1, 1'000'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_sessions_per_token; },
          "of these, those that began with one token")),
      Live(Whole(
          "max_streams_per_address", 1, 1'000'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_streams_per_address; },
          "games' streams from one address that is not the daemon's own machine")),
      Live(Whole(
          "max_projects", 1, 1'000'000, 1, [](Config & c) -> auto& { return c.rpc.max_projects; },
          "projects; games and imports name them")),
      Live(Whole(
          "max_scenes", 1, 1'000'000, 1, [](Config & c) -> auto& { return c.rpc.max_scenes; },
          "scenes of a project, by name")),
      Live(Whole(
          "max_messages_per_s", 1, 1'000'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_messages_per_s; },
          "messages of a game in a second, times its time scale; at once, as many as in ten "
          "seconds")),
      Live(Whole(
          "max_hellos_per_s", 1, 1'000'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_hellos_per_s; },
          "streams that a token, and an address that is not the daemon's own machine, begins in a "
          "second; at once, as many as in ten seconds, so that 10,000 games behind one address "
          "come back unhindered after a restart")),
      Live(Whole(
          "max_reads_per_s", 1, 1'000'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_reads_per_s; },
          "calls of a token, and of an address, in a second that list, export or begin to watch; "
          "at once, as many as in ten seconds")),
      Live(Whole(
          "max_transfers", 1, 100'000, 1, [](Config & c) -> auto& { return c.rpc.max_transfers; },
          "exports and imports at a time")),
      Live(Whole(
          "max_transfers_per_token", 1, 100'000, 1,
          [](Config & c) -> auto& { return c.rpc.max_transfers_per_token; },
          "of these, those of one token")),
      Live(Whole(
          "max_watchers", 1, 100'000, 1, [](Config & c) -> auto& { return c.rpc.max_watchers; },
          "watchers at a time; a token, and an address, may have half of them")),
      Live(Whole(
          "resume_window_ms", 0, kYearMs, kNsPerMs,
          [](Config & c) -> auto& { return c.rpc.resume_window_ns; },
          "how long a lost session stays in memory")),
      Whole(
          "memory_quota_mb", 8, 1 << 20, 1 << 20,
          [](Config & c) -> auto& { return c.rpc.memory_quota_bytes; },
          "memory of all connections' buffers"),
      Live(Whole(
          "database_mb", 8, 1 << 24, 1 << 20, [](Config & c) -> auto& { return c.database_bytes; },
          "size of priors.db; beyond it nothing more is stored or acknowledged")),
      Live(Whole(
          "backup_count", 0, 1'000, 1, [](Config & c) -> auto& { return c.backup_count; },
          "backups that are kept beside priors.db; 0 makes none")),
      Live(Whole(
          "backup_hours", 1, 8'760, 1, [](Config & c) -> auto& { return c.backup_hours; },
          "time from one backup to the next")),
      Live(Whole(
          "audit_mb", 0, 1 << 20, 1 << 20, [](Config & c) -> auto& { return c.audit.bytes; },
          "text of the audit log; beyond it the oldest rows go; 0 keeps none but the "
          "administrators'")),
      Live(Whole(
          "audit_days", 1, 36'500, 86'400, [](Config & c) -> auto& { return c.audit.age_s; },
          "age at which rows of the audit log go")),
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
          "min time between two switches; of adaptive the longest that it waits"),
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
          "try every arm once at the start; adaptive does not"),
      Real(
          "decision.bail_out_penalty",
          [](Config & c) -> auto& { return c.rpc.decision.bail_out_penalty; },
          "zero-reward observations that a bail-out counts as"),
      Real(
          "decision.fps_floor", [](Config & c) -> auto& { return c.rpc.decision.fps_floor; },
          "frames/s below which even the best arm is a degraded scene"),
  };
}

}  // namespace

std::string ShortestText(double number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

std::vector<Setting> Settings() {
  std::vector<Setting> settings = DaemonSettings();
  for (Setting& setting : DecisionSettings()) settings.push_back(std::move(setting));
  return settings;
}

}  // namespace sweepstake::server
