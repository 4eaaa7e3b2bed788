// `sweepstake alerts`: shows the conditions of a daemon that need a person.
#include <nlohmann/json.hpp>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

struct AlertsOptions {
  DaemonOptions daemon;
  std::string project;
  bool json = false;
};

std::string SeverityText(v1::AlertSeverity severity) {
  return severity == v1::ALERT_SEVERITY_SERIOUS ? "serious" : "notice";
}

Json AlertJson(const v1::Alert& alert) {
  Json json = {{"id", alert.id()},
               {"rule", alert.rule()},
               {"severity", SeverityText(alert.severity())},
               {"text", alert.text()},
               {"unix_since_ms", alert.unix_since_ms()}};
  if (!alert.project().empty()) {
    json["project"] = alert.project();
    json["scene"] = alert.scene();
    json["machine_class"] = alert.machine_class();
    json["reward_version"] = alert.reward_version();
    json["session_count"] = alert.session_count();
    json["session_ids"] = alert.session_ids();
  }
  if (alert.has_loss_us()) json["loss_us"] = alert.loss_us();
  if (alert.has_silence()) {
    const v1::AlertSilence& silence = alert.silence();
    const int64_t until_ms = silence.unix_until_ms();
    json["silence"] = {{"unix_until_ms", until_ms > 0 ? Json(until_ms) : Json()},
                       {"comment", silence.comment()},
                       {"silenced_by", silence.silenced_by()}};
  }
  return json;
}

std::string AlertsText(const v1::ListAlertsResponse& list) {
  if (list.alert_count() == 0) return "Nothing needs a person\n";
  TextTable table({"severity", "project", "scene", "class", "since (UTC)", "muted by", "what"});
  for (const v1::Alert& alert : list.alerts()) {
    table.AddRow({SeverityText(alert.severity()), alert.project(), alert.scene(),
                  alert.machine_class(), UtcText(alert.unix_since_ms()),
                  alert.silence().silenced_by(), alert.text()});
  }
  const int left_out = static_cast<int>(list.alert_count()) - list.alerts_size();
  return table.Text() +
         (left_out > 0 ? std::to_string(left_out) + " more alerts with less loss\n" : "");
}

int RunAlerts(const AlertsOptions& options, Terminal& terminal) {
  const auto list = ListAlerts(options.daemon, options.project);
  if (!list.ok()) return FailAnswer(terminal, list.status());
  Json alerts = Json::array();
  for (const v1::Alert& alert : list->alerts()) alerts.push_back(AlertJson(alert));
  PrintResult(terminal, options.json,
              {{"command", "alerts"},
               {"daemon", options.daemon.address},
               {"alerts", std::move(alerts)},
               {"alert_count", list->alert_count()},
               {"serious_count", list->serious_count()}},
              AlertsText(*list));
  return kDone;
}

}  // namespace

void AddAlertsCommand(const CommandContext& context) {
  AddCommand<AlertsOptions>(
      context, "alerts", "List what needs a person, the most urgent first",
      "  sweepstake alerts --daemon 127.0.0.1:7433\n"
      "  sweepstake alerts --daemon 127.0.0.1:7433 --project game --json\n",
      [](CLI::App& command, AlertsOptions& options) {
        AddDaemonOptions(command, options.daemon);
        command.add_option("--project", options.project,
                           "Only this project (default: all, and the daemon itself)");
        AddJsonFlag(command, options.json);
      },
      RunAlerts);
}

}  // namespace sweepstake::cli
