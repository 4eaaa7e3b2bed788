// The table of settings (config.h).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <type_traits>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "engine_client/text/names.h"
#include "server/config.h"

namespace sweepstake::server {
namespace {

std::string FlagOf(const std::string& key) {
  return "--" + absl::StrReplaceAll(key, {{".", "-"}, {"_", "-"}});
}

std::string VariableOf(const std::string& key) {
  return "SWEEPSTAKE_" + absl::AsciiStrToUpper(absl::StrReplaceAll(key, {{".", "_"}}));
}

constexpr const char* kFixedGroup = "Settings that need a restart";
constexpr const char* kLiveGroup = "Settings that SIGHUP reloads";
constexpr const char* kDecisionGroup = "Decisions (need a restart)";

constexpr int64_t kYearMs = 31'536'000'000;
constexpr int64_t kMiB = 1 << 20;

CLI::Validator Line() {
  return {[](const std::string& text) -> std::string {
            return text::IsLine(text) ? "" : "expected UTF-8 without control characters";
          },
          ""};
}

CLI::Validator Finite() {
  return {[](const std::string& text) -> std::string {
            double number = 0;
            if (absl::SimpleAtod(text, &number) && std::isfinite(number)) return "";
            return absl::StrCat("expected a finite number, not ", text);
          },
          ""};
}

CLI::Validator BasePath() {
  return {
      [](const std::string& text) -> std::string {
        const bool is_valid = std::all_of(text.begin(), text.end(), [](char c) {
          return absl::ascii_isalnum(static_cast<unsigned char>(c)) || absl::StrContains("/-_", c);
        });
        const bool is_path = is_valid && text.starts_with('/') && !text.ends_with('/') &&
                             !absl::StrContains(text, "//");
        if (!text.empty() && !is_path)
          return "expected a path such as /sweepstake, of letters, digits, - and _";
        // Below these, the daemon's own pages could not be reached.
        for (const char* own :
             {"/api", "/events", "/login", "/logout", "/metrics", "/livez", "/readyz", "/assets"}) {
          if (absl::StartsWith(text + "/", absl::StrCat(own, "/")))
            return absl::StrCat(own, " is a path of the daemon; choose another");
        }
        return "";
      },
      ""};
}

CLI::Validator HttpUrl() {
  return {[](const std::string& text) -> std::string {
            static const std::regex shape("https?://[^\\s/?#]+([/?][^\\s#]*)?");
            return text.empty() || std::regex_match(text, shape)
                       ? ""
                       : "expected a URL such as https://example.org/alerts";
          },
          ""};
}

// Adds settings of each type. The fields must outlive the application.
class Table {
 public:
  Table(CLI::App& app, std::vector<Settings::Setting>& settings) : app_(app), settings_(settings) {}

  void Group(const std::string& name) {
    app_.option_defaults()->group(name);
    is_live_ = name == kLiveGroup;
  }

  template <typename Field>
  CLI::Option* Text(const std::string& key, Field& field, const std::string& help) {
    return Add(key, app_.add_option(FlagOf(key), field)->check(Line()), help,
               [&field] { return nlohmann::json(std::string(field)).dump(); });
  }

  void Switch(const std::string& key, bool& field, const std::string& help) {
    const std::string flag = FlagOf(key);
    CLI::Option* option = app_.add_flag(flag + ",!--no-" + flag.substr(2), field);
    Add(key, option->check(CLI::IsMember({"true", "false"}).description("")), help,
        [&field] { return nlohmann::json(field).dump(); });
  }

  void Real(const std::string& key, double& field, const std::string& help) {
    CLI::Option* option = app_.add_option_function<std::string>(
        FlagOf(key), [&field](const std::string& text) { (void)absl::SimpleAtod(text, &field); });
    Add(key, option->check(Finite())->type_name("FLOAT"), help,
        [&field] { return nlohmann::json(field).dump(); });
  }

  // Adds a whole number from `min` to `max`. The field holds the number times `unit`.
  template <typename Field>
  void Whole(const std::string& key, Field& field, int64_t min, int64_t max,
             const std::string& help, int64_t unit = 1) {
    CLI::Option* option = app_.add_option_function<int64_t>(
        FlagOf(key),
        [&field, unit](const int64_t& number) { field = static_cast<Field>(number * unit); });
    Add(key, option->check(CLI::Range(min, max)), help,
        [&field, unit] { return absl::StrCat(static_cast<int64_t>(field) / unit); });
  }

 private:
  CLI::Option* Add(const std::string& key, CLI::Option* option, const std::string& help,
                   const std::function<std::string()>& value) {
    const std::string variable = VariableOf(key);
    option->description(absl::StrCat(help, " [", key, ", ", variable, "]"));
    option->default_function(value)->capture_default_str();
    settings_.push_back({key, variable, option, is_live_});
    return option;
  }

  CLI::App& app_;
  std::vector<Settings::Setting>& settings_;
  bool is_live_ = false;
};

void AddFixed(Table& table, Config& config) {
  table.Group(kFixedGroup);
  table.Text("listen", config.listen, "HOST:PORT to serve gRPC on; port 0 means any free port");
  table.Text("http", config.http,
             "HOST:PORT to serve the dashboard, /metrics, /livez and /readyz on; empty: no HTTP");
  table.Text("http_hosts", config.http_hosts,
             "further host names of the dashboard, separated by commas, for instance that of a "
             "proxy in front of it");
  table
      .Text("http_base", config.http_base,
            "path under which a proxy serves the dashboard, such as /sweepstake; empty: /")
      ->check(BasePath());
  table.Text("data", config.data,
             "directory of the prior store; created if its parent directory exists");
  table.Text("store", config.store,
             "postgresql:// URL, without a password, of a prior store that several daemons share; "
             "empty: priors.db in `data`");
  table.Text("port_file", config.port_file,
             "file that receives the gRPC port and, in its second line, the HTTP port, as soon as "
             "the daemon listens");
  table.Switch("require_tokens", config.require_tokens,
               "refuse to start without a token, on loopback addresses too; for daemons behind a "
               "proxy");
  table.Switch(
      "trusted_proxy", config.rpc.trusts_proxy,
      "clients on the daemon's machine are a proxy, whose header x-forwarded-for names the "
      "real client; implies require_tokens");
  table.Switch("insecure", config.insecure,
               "let other machines use gRPC in plain text and without tokens");
  table.Switch("http_plain", config.http_plain,
               "let other machines use HTTP in plain text, for instance through a proxy that ends "
               "TLS");
  table.Text("tls_cert", config.rpc.tls.cert,
             "PEM file of the server certificate, followed by its issuers; checked for changes "
             "every second");
  table.Text("tls_key", config.rpc.tls.key, "PEM file of the certificate's private key");
  table.Text("tls_client_ca", config.rpc.tls.ca,
             "PEM file of the authorities that must have signed a client's certificate");
  table.Switch("reflection", config.rpc.reflection,
               "serve gRPC reflection, for tools such as grpcurl");
  table.Whole("memory_quota_mb", config.rpc.memory_quota_bytes, 8, 1 << 20,
              "memory for the buffers of all connections, in MiB", kMiB);
}

void AddLive(Table& table, Config& config) {
  rpc::RpcOptions& rpc = config.rpc;
  constexpr int64_t kMillion = 1'000'000;
  table.Group(kLiveGroup);
  table.Text("log_level", config.log_level, "least severe level of the log lines that are written")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}));
  table.Whole("max_time_scale", rpc.max_time_scale, 1, static_cast<int64_t>(rpc::kMaxTimeScale),
              "largest time scale that a game may request, for experiments; such a game decides, "
              "learns and commits that many times as often");
  table.Whole("max_sessions", rpc.max_sessions, 1, kMillion,
              "sessions in memory, connected or resumable; each counts once per 8 arms");
  table.Whole("max_sessions_per_party", rpc.max_sessions_per_party, 1, kMillion,
              "sessions in memory of one player, network or token");
  table.Whole("max_streams_per_address", rpc.max_streams_per_address, 1, kMillion,
              "game streams from one remote address");
  table.Whole("max_projects", rpc.max_projects, 1, kMillion, "projects of games and imports");
  table.Whole("max_scenes", rpc.max_scenes, 1, kMillion, "scene names per project");
  table.Whole("max_messages_per_s", rpc.max_messages_per_s, 1, kMillion,
              "messages per second of each game, times its time scale; burst: ten times this");
  table.Whole("max_hellos_per_s", rpc.max_hellos_per_s, 1, kMillion,
              "new streams per second for each token and remote address; burst: ten times this");
  table.Whole("max_reads_per_s", rpc.max_reads_per_s, 1, kMillion,
              "calls per second for each token and address, without streams of games; burst: ten "
              "times this");
  table.Whole("max_transfers", rpc.max_transfers, 1, 100'000,
              "exports and imports in progress at one time");
  table.Whole("max_transfers_per_token", rpc.max_transfers_per_token, 1, 100'000,
              "exports and imports in progress at one time for each token");
  table.Whole("max_watchers", rpc.max_watchers, 1, 100'000,
              "watchers at one time; each token and remote address may have half of them");
  table.Whole("resume_window_ms", rpc.resume_window_ns, 0, kYearMs,
              "time in ms that a session stays in memory after its connection is lost",
              rpc::kNsPerMs);
  table.Whole("database_mb", config.database_bytes, 8, 1 << 24,
              "maximum size of priors.db in MiB; a full store accepts no new evidence", kMiB);
  table.Whole("backup_count", config.backup_count, 0, 1'000,
              "number of backups that are kept next to priors.db; 0: no backups");
  table.Whole("backup_hours", config.backup_hours, 1, 8'760, "hours between two backups");
  table
      .Text("webhook", config.webhook,
            "http or https URL that receives a JSON message when alerts begin or end; empty: none")
      ->check(HttpUrl());
  table.Whole("metrics_scenes", rpc.alerts.max_metric_scenes, 0, 1'000,
              "maximum number of scenes with series of their own in /metrics, those with the most "
              "sessions; 0: none");
  table.Whole("audit_mb", config.audit.bytes, 0, 1 << 20,
              "size of the audit log in MiB; older rows are deleted first; 0 keeps only the rows "
              "of administrators",
              kMiB);
  table.Whole("audit_days", config.audit.age_s, 1, 36'500,
              "age in days at which audit rows are deleted", 86'400);
  table.Whole("history_mb", config.history.bytes, 1, 1 << 20,
              "maximum size of history.db in MiB; the oldest points are deleted first", kMiB);
  table.Whole("history_days", config.history.age_s, 1, 36'500,
              "age in days at which points of the history are deleted", 86'400);
}

void AddDecision(Table& table, decision::DecisionOptions& options) {
  const auto milliseconds = [&](const char* key, auto& field, const char* help) {
    table.Whole(key, field, 0, kYearMs, help, rpc::kNsPerMs);
  };
  table.Group(kDecisionGroup);
  table.Text("decision.policy", options.policy,
             "policy of sessions that request none: adaptive (compares expected costs), or paper "
             "(Thompson sampling)");
  table.Real("decision.weight_fps", options.weights.fps, "weight of the FPS score");
  table.Real("decision.weight_detection", options.weights.detection,
             "weight of the detection time score");
  table.Real("decision.weight_memory", options.weights.memory, "weight of the memory score");
  table.Real("decision.weight_checks", options.weights.checks, "weight of the AABB check score");
  milliseconds("decision.interval_ms", options.decision_interval_ns,
               "time between two decisions, in ms");
  milliseconds("decision.cooldown_ms", options.cooldown_ns,
               "minimum time between two switches, in ms; policy adaptive waits at most this long, "
               "and less if switches are cheap");
  milliseconds("decision.settling_ms", options.settling_ns,
               "frame time after a switch, in ms, that is excluded from learning");
  milliseconds("decision.bail_out_ms", options.bail_out_ns,
               "a frame longer than this, in ms, is a bail-out");
  milliseconds("decision.exploration_warm_up_ms", options.exploration_warm_up_ns,
               "warm-up per arm during exploration, in ms");
  milliseconds("decision.exploration_measure_ms", options.exploration_measure_ns,
               "measured time per arm during exploration, in ms");
  table.Switch("decision.explore", options.explore,
               "try every arm once at the start; policy adaptive ignores this");
  table.Real("decision.bail_out_penalty", options.bail_out_penalty,
             "number of zero-reward observations that a bail-out counts as");
  table.Real("decision.fps_floor", options.fps_floor,
             "frames per second; a scene that misses it because of the broad phase is degraded");
}

}  // namespace

Settings::Settings(CLI::App& app, Config& config) {
  const std::string group = app.option_defaults()->get_group();
  Table table(app, settings_);
  AddFixed(table, config);
  AddLive(table, config);
  AddDecision(table, config.rpc.decision);
  table.Group(group);
}

}  // namespace sweepstake::server
