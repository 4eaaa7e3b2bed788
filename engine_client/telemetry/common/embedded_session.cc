// The session without a daemon: its sender thread runs an embedded decider in a DeciderLoop.
#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "engine_client/broad_phase/host/thread_owned.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/telemetry/common/decider_loop.h"
#include "engine_client/telemetry/common/session_base.h"
#include "engine_client/telemetry/common/study_session.h"
#include "engine_client/telemetry/common/validation.h"

namespace sweepstake {
namespace {

class EmbeddedSession final : public SessionBase {
 public:
  EmbeddedSession(StudyMaker maker, EmbeddedOptions embedded, const SessionOptions& options)
      : SessionBase(options), maker_(maker), embedded_(std::move(embedded)) {}
  ~EmbeddedSession() override { Stop(0); }

  Result<std::string> ExportPriors() const override;

 private:
  Status Prepare(AdaptiveBroadPhase& adaptive) override;
  bool Step(bool stopping) override;
  // A tenth of the scaled decision interval, but 1 to 5 ms, so that decisions are made on time.
  std::chrono::milliseconds poll_interval() const override {
    const auto interval_ns = static_cast<double>(embedded_.decision_interval_ns);
    const double tenth_ms = interval_ns * 1e-6 / embedded_.time_scale / 10;
    return std::chrono::milliseconds(static_cast<int64_t>(std::clamp(tenth_ms, 1.0, 5.0)));
  }

  void TakeQueue(uint64_t now_ns);
  void Decide(uint64_t now_ns);
  void PublishBeliefs();

  const StudyMaker maker_;
  const EmbeddedOptions embedded_;
  mutable std::mutex mutex_;       // shared by the sender thread and ExportPriors
  ThreadOwned<DeciderLoop> loop_;  // guarded by mutex_; null before Prepare
};

Status EmbeddedSession::Prepare(AdaptiveBroadPhase& adaptive) {
  EmbeddedOptions options = embedded_;
  options.mode = adaptive.mode();
  options.initial_arm = adaptive.initial_arm();
  const uint64_t now_ns = SteadyClock().NowNs();
  auto decider = maker_.MakeDecider(options, adaptive.arms(), adaptive.arm_versions(), now_ns);
  if (!decider.ok()) return decider.status();
  (*decider)->SetMode(adaptive.mode(), adaptive.active_arm(), now_ns);
  const std::lock_guard lock(mutex_);
  loop_ = MakeThreadOwned<DeciderLoop>(queue(), adaptive, std::move(*decider));
  UpdateStats([&](SessionStats& stats) {
    stats.state = ConnectionState::kEmbedded;
    stats.prior_source_count = loop_->decider().prior_source_count();
  });
  return {};
}

Result<std::string> EmbeddedSession::ExportPriors() const {
  const std::lock_guard lock(mutex_);
  if (!loop_) return Status(StatusCode::kFailedPrecondition, "call Start first");
  return loop_->decider().ExportPriors();
}

bool EmbeddedSession::Step(bool stopping) {
  const std::lock_guard lock(mutex_);
  const uint64_t now_ns = SteadyClock().NowNs();
  TakeQueue(now_ns);
  if (!stopping) Decide(now_ns);
  if (loop_->has_news()) PublishBeliefs();
  return !stopping;
}

void EmbeddedSession::TakeQueue(uint64_t now_ns) {
  const uint64_t frame_count = loop_->TakeQueue(now_ns);
  const uint64_t end_ns = SteadyClock().NowNs();
  UpdateStats([&](SessionStats& stats) {
    stats.sent_frame_count += frame_count;
    stats.intake_time_ns += end_ns - now_ns;
  });
}

void EmbeddedSession::Decide(uint64_t now_ns) {
  const uint64_t start_ns = SteadyClock().NowNs();
  const std::optional<SwitchCommand> command = loop_->Decide(now_ns);
  if (!loop_->has_news()) return;
  const uint64_t spent_ns = SteadyClock().NowNs() - start_ns;
  UpdateStats([&](SessionStats& stats) {
    stats.decision_time_ns += spent_ns;
    stats.longest_decision_ns = std::max(stats.longest_decision_ns, spent_ns);
    if (command) ++stats.command_count;
  });
}

void EmbeddedSession::PublishBeliefs() {
  loop_->PublishBeliefs();
  UpdateStats([&](SessionStats& stats) {
    stats.beliefs = loop_->decider().beliefs();
    stats.verdict = loop_->decider().verdict();
    stats.saved_us = loop_->decider().saved_us();
  });
}

}  // namespace

Result<std::unique_ptr<Session>> MakeEmbeddedSession(const EmbeddedOptions& embedded,
                                                     const SessionOptions& options) {
  return MakeStudySession({decision::ShippedPolicies()}, embedded, options);
}

Result<std::unique_ptr<Session>> MakeStudySession(const StudyMaker& maker,
                                                  const EmbeddedOptions& embedded,
                                                  const SessionOptions& options) {
  if (Status status = ValidateSessionOptions(options); !status.ok()) return status;
  return std::unique_ptr<Session>(std::make_unique<EmbeddedSession>(maker, embedded, options));
}

}  // namespace sweepstake
