// The connections of the alerts (daemon.h).
#include <spdlog/logger.h>

#include <utility>

#include "server/alerts/webhook_message.h"
#include "server/daemon.h"
#include "server/daemon_files.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::server {

std::vector<alerts::CheckResult> Daemon::Checks() const {
  return {{.name = "store", .problem = StoreProblem().value_or(""), .remark = damage_},
          {.name = "tls", .problem = TlsProblem().value_or(""), .remark = {}}};
}

alerts::AlertOptions Daemon::AlertOptionsOf() {
  alerts::AlertOptions options;
  options.checks = [this] { return Checks(); };
  options.announce = [this](const alerts::AlertChanges& changes) { Announce(changes); };
  options.save_silences = [this](std::string text) { SaveSilences(std::move(text)); };
  options.silences = ReadText(directory_.silences());
  options.max_metric_scenes = config_.rpc.alerts.max_metric_scenes;
  return options;
}

void Daemon::Announce(const alerts::AlertChanges& changes) {
  const alerts::WebhookContext context = {.daemon_version = SWEEPSTAKE_VERSION,
                                          .page_url = page_url_};
  const auto post = [&](const char* status, const std::vector<alerts::Alert>& changed) {
    if (!changed.empty())
      webhook_.Post(alerts::WebhookMessage(status, changed, priors::UnixNowMs(), context));
  };
  post("ends", changes.ended);
  post("begins", changes.begun);
}

void Daemon::SaveSilences(std::string text) {
  const auto report = [this](absl::string_view why) {
    log_->error("{} could not be written, so the silences of alerts are lost at a restart: {}",
                directory_.silences().string(), std::string(why));
  };
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(unsaved_silences_, std::move(text)))
      return;  // the queued job writes this one
  }
  // The store's thread writes the file, because an fsync would delay decisions.
  const auto save = [this, report](priors::PriorStore& /*store*/) {
    std::optional<std::string> latest;
    {
      const std::lock_guard lock(mutex_);
      latest = std::exchange(unsaved_silences_, std::nullopt);
    }
    if (const absl::Status saved = ReplaceText(directory_.silences(), *latest); !saved.ok())
      report(saved.message());
  };
  if (store_->Submit(save)) return;
  const std::lock_guard lock(mutex_);
  unsaved_silences_.reset();
  report("the queue of the store is full");
}

}  // namespace sweepstake::server
