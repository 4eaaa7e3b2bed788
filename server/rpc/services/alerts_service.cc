#include "server/rpc/services/alerts_service.h"

#include <spdlog/logger.h>

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/text/names.h"
#include "server/alerts/alert_monitor.h"
#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

constexpr uint32_t kAlertsPerList = 100;  // unless the request has another limit
constexpr uint64_t kMaxSilenceMs = 31'536'000'000;
constexpr size_t kMaxCommentBytes = 200;

// Everybody who may list alerts sees those of the whole daemon, which have no project.
bool MaySee(const Caller& caller, const alerts::Alert& alert) {
  const std::string& project = alert.key.scene.project;
  return project.empty() || caller.MayUse(project);
}

// Returns the alert if the caller may silence it; else null, so that the answer does not reveal
// whether it exists. A token for some projects does not silence alerts of the whole daemon.
const alerts::Alert* FindAlertFor(const ServiceContext& context, const Caller& caller,
                                  const std::string& id) {
  const alerts::Alert* alert = context.alerts.board().Find(id);
  return alert != nullptr && caller.MayUse(alert->key.scene.project) ? alert : nullptr;
}

absl::Status UnknownAlert(const char* message) {
  return Refused(v1::ERROR_REASON_UNKNOWN_ALERT, message);
}

// Returns the alert for the log.
std::string TextOf(const alerts::Alert& alert) {
  const priors::SceneKey& scene = alert.key.scene;
  return absl::StrCat(
      "the alert ", std::string(alerts::NameOf(alert.key.rule)), " of ",
      scene.project.empty()
          ? absl::StrCat("the check ", alert.key.check)
          : absl::StrCat(scene.project, "/", scene.scene, scene.machine_class.empty() ? "" : " on ",
                         scene.machine_class));
}

void RecordForAlerts(ServiceContext& context, const Caller& caller, const std::string& action) {
  const std::string who = NameAndAddress(caller);
  context.log.info("{} {}", who, action);
  context.admin.Record(who, action);
}

absl::Status CheckSilence(const v1::SilenceAlertRequest& request) {
  if (request.duration_ms() > kMaxSilenceMs)
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE, "duration_ms is longer than a year");
  if (request.comment().size() > kMaxCommentBytes || !text::IsLine(request.comment())) {
    return Refused(
        v1::ERROR_REASON_INVALID_MESSAGE,
        absl::StrCat("comment must be one line of at most ", kMaxCommentBytes, " bytes of UTF-8"));
  }
  return absl::OkStatus();
}

// Silences the alert on the loop.
absl::Status Silence(ServiceContext& context, const Caller& caller,
                     const v1::SilenceAlertRequest& request) {
  const alerts::Alert* alert = FindAlertFor(context, caller, request.alert_id());
  if (alert == nullptr) return UnknownAlert("the daemon has no such alert; list the alerts again");
  const auto duration_ms = static_cast<int64_t>(request.duration_ms());
  std::string action = absl::StrCat(
      "silenced ", TextOf(*alert),
      duration_ms == 0 ? " until it ends" : absl::StrCat(" for ", duration_ms / 1000, " s"));
  if (!request.comment().empty()) absl::StrAppend(&action, ": ", request.comment());
  const absl::Status silenced = context.alerts.AddSilence(
      {.id = alert->id, .comment = request.comment(), .silenced_by = NameAndAddress(caller)},
      duration_ms);
  if (!silenced.ok()) return Refused(v1::ERROR_REASON_TOO_MANY_SILENCES, silenced.message());
  RecordForAlerts(context, caller, action);
  return absl::OkStatus();
}

}  // namespace

void Answer(ServiceContext& context, const Caller& caller, const v1::ListAlertsRequest& request,
            v1::ListAlertsResponse& response, const EndCall& end) {
  if (!request.project().empty()) {
    if (const absl::Status allowed = CheckProject(caller, request.project()); !allowed.ok())
      return end(allowed);
  }
  context.loop.Post([&context, &request, &response, caller, end] {
    const uint32_t limit = request.limit() == 0 ? kAlertsPerList : request.limit();
    uint32_t count = 0;
    uint32_t serious_count = 0;
    for (const alerts::Alert& alert : context.alerts.board().ranked()) {
      const bool is_selected =
          request.project().empty() || request.project() == alert.key.scene.project;
      if (!is_selected || !MaySee(caller, alert)) continue;
      if (count++ < limit) ToProto(alert, *response.add_alerts());
      if (!alert.silence && alert.finding.severity == alerts::Severity::kSerious) ++serious_count;
    }
    response.set_alert_count(count);
    response.set_serious_count(serious_count);
    end(absl::OkStatus());
  });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::SilenceAlertRequest& request,
            v1::SilenceAlertResponse& /*response*/, const EndCall& end) {
  if (const absl::Status valid = CheckSilence(request); !valid.ok()) return end(valid);
  context.loop.Post([&context, &request, caller, end] { end(Silence(context, caller, request)); });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::UnsilenceAlertRequest& request,
            v1::UnsilenceAlertResponse& /*response*/, const EndCall& end) {
  context.loop.Post([&context, &request, caller, end] {
    const alerts::Alert* alert = FindAlertFor(context, caller, request.alert_id());
    // The silence of an alert that is not there now has no project: only callers for all projects
    // may end it.
    const bool is_absent = context.alerts.board().Find(request.alert_id()) == nullptr;
    const bool may_end = alert != nullptr || (is_absent && caller.projects.empty());
    const std::string name =
        alert == nullptr ? absl::StrCat("the absent alert ", request.alert_id()) : TextOf(*alert);
    if (!may_end || !context.alerts.Unsilence(request.alert_id()))
      return end(UnknownAlert("the daemon has no such alert with a silence; list them again"));
    RecordForAlerts(context, caller, "ended the silence of " + name);
    end(absl::OkStatus());
  });
}

}  // namespace sweepstake::rpc
