// The session without a daemon: the sender thread feeds the embedded decider and posts its
// commands.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <utility>

#include "engine_client/telemetry/polling_thread.h"
#include "engine_client/telemetry/sample_queue.h"
#include "engine_client/telemetry/session_options.h"
#include "sweepstake/session.h"

namespace sweepstake {
namespace {

constexpr double kDecisionIntervalMs = 2000;
// Frames handed over at once; bounds the buffer, not what is taken per step.
constexpr size_t kRunFrames = 256;

class EmbeddedSession final : public Session {
 public:
  EmbeddedSession(EmbeddedOptions embedded, const SessionOptions& options)
      : embedded_(std::move(embedded)), queue_(options.queue_frames) {
    run_.reserve(kRunFrames);
  }
  ~EmbeddedSession() override { Stop(0); }

  FrameSink& sink() override { return queue_; }
  Status Start(AdaptiveBroadPhase& adaptive) override;
  void OnModeChange() override;
  void Stop(uint32_t deadline_ms) override;
  SessionStats stats() const override;

 private:
  // A tenth of the scaled decision interval at most, so that decisions come on time.
  std::chrono::milliseconds PollInterval() const {
    const double tenth_ms = kDecisionIntervalMs / embedded_.time_scale / 10;
    return std::chrono::milliseconds(static_cast<int64_t>(std::clamp(tenth_ms, 1.0, 5.0)));
  }

  bool Step(bool stopping);
  void TakeQueue(uint64_t now_ns);
  void Take(const QueuedItem& item, uint64_t now_ns);
  void ObserveRun(uint64_t now_ns);
  void Decide(uint64_t now_ns);
  void PublishBeliefs();

  const EmbeddedOptions embedded_;
  SampleQueue queue_;
  std::atomic<AdaptiveBroadPhase*> adaptive_{nullptr};

  // On the sender thread.
  std::unique_ptr<EmbeddedDecider> decider_;
  std::vector<FrameSample> run_;
  uint64_t published_decision_count_ = ~uint64_t{0};

  mutable std::mutex stats_mutex_;
  SessionStats stats_;  // guarded by stats_mutex_
  PollingThread thread_;
};

Status EmbeddedSession::Start(AdaptiveBroadPhase& adaptive) {
  if (adaptive_.load() != nullptr || stats().state == ConnectionState::kClosed) {
    return {StatusCode::kFailedPrecondition, "the session was started before; make a new one"};
  }
  EmbeddedOptions options = embedded_;
  options.mode = adaptive.mode();
  auto decider = EmbeddedDecider::Create(options, adaptive.arms(), adaptive.arm_versions(),
                                         SteadyClock().NowNs());
  if (!decider.ok()) return decider.status();
  decider_ = std::move(*decider);
  decider_->SetMode(adaptive.mode(), adaptive.active_arm(), SteadyClock().NowNs());
  adaptive_.store(&adaptive);
  adaptive.SetDeciderPresent(true);
  {
    const std::lock_guard lock(stats_mutex_);
    stats_.state = ConnectionState::kEmbedded;
    stats_.prior_source_count = decider_->prior_source_count();
  }
  thread_.Start(PollInterval(), [this](bool stopping) { return Step(stopping); });
  return {};
}

void EmbeddedSession::OnModeChange() {
  const AdaptiveBroadPhase* adaptive = adaptive_.load(std::memory_order_relaxed);
  if (adaptive == nullptr) return;
  queue_.OnModeChange({.mode = adaptive->mode(), .active_arm = adaptive->active_arm()});
}

void EmbeddedSession::Stop(uint32_t /*deadline_ms*/) {
  thread_.RequestStop();
  thread_.Join();
  AdaptiveBroadPhase* adaptive = adaptive_.exchange(nullptr);
  if (adaptive != nullptr) adaptive->SetDeciderPresent(false);
  const std::lock_guard lock(stats_mutex_);
  stats_.state = ConnectionState::kClosed;
}

SessionStats EmbeddedSession::stats() const {
  const std::lock_guard lock(stats_mutex_);
  SessionStats stats = stats_;
  stats.dropped_frame_count = queue_.dropped_frame_count();
  return stats;
}

bool EmbeddedSession::Step(bool stopping) {
  const uint64_t now_ns = SteadyClock().NowNs();
  TakeQueue(now_ns);
  if (!stopping) Decide(now_ns);
  PublishBeliefs();
  return !stopping;
}

void EmbeddedSession::TakeQueue(uint64_t now_ns) {
  while (const std::optional<QueuedItem> item = queue_.Pop()) Take(*item, now_ns);
  ObserveRun(now_ns);
  while (const std::optional<ShadowSample> sample = queue_.PopShadow()) {
    decider_->Observe({&*sample, 1});
  }
  const uint64_t end_ns = SteadyClock().NowNs();
  const std::lock_guard lock(stats_mutex_);
  stats_.intake_time_ns += end_ns - now_ns;
}

void EmbeddedSession::Take(const QueuedItem& item, uint64_t now_ns) {
  if (const auto* frame = std::get_if<FrameSample>(&item)) {
    run_.push_back(*frame);
    if (run_.size() == kRunFrames) ObserveRun(now_ns);
    return;
  }
  ObserveRun(now_ns);
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item)) decider_->Observe(*outcome, now_ns);
  if (const auto* seen = std::get_if<SceneDescriptor>(&item)) decider_->Observe(*seen);
  if (const auto* note = std::get_if<ModeNote>(&item)) {
    decider_->SetMode(note->mode, note->active_arm, now_ns);
  }
}

void EmbeddedSession::ObserveRun(uint64_t now_ns) {
  if (run_.empty()) return;
  decider_->Observe(run_, now_ns);
  const std::lock_guard lock(stats_mutex_);
  stats_.sent_frame_count += run_.size();
  run_.clear();
}

void EmbeddedSession::Decide(uint64_t now_ns) {
  const uint64_t start_ns = SteadyClock().NowNs();
  const std::optional<SwitchCommand> command = decider_->Poll(now_ns);
  if (command) adaptive_.load()->mailbox().Post(*command);
  if (decider_->decision_count() == published_decision_count_) return;
  const uint64_t spent_ns = SteadyClock().NowNs() - start_ns;
  const std::lock_guard lock(stats_mutex_);
  stats_.decision_time_ns += spent_ns;
  stats_.longest_decision_ns = std::max(stats_.longest_decision_ns, spent_ns);
  if (command) ++stats_.command_count;
}

void EmbeddedSession::PublishBeliefs() {
  if (decider_->decision_count() == published_decision_count_) return;
  published_decision_count_ = decider_->decision_count();
  std::vector<ArmBelief> beliefs = decider_->beliefs();
  std::vector<double> means;
  means.reserve(beliefs.size());
  for (const ArmBelief& belief : beliefs)
    means.push_back(belief.alpha / (belief.alpha + belief.beta));
  adaptive_.load()->SetPosteriorMeans(means);
  adaptive_.load()->SetVerdict(decider_->verdict());
  const std::lock_guard lock(stats_mutex_);
  stats_.beliefs = std::move(beliefs);
  stats_.verdict = decider_->verdict();
}

}  // namespace

Result<std::unique_ptr<Session>> MakeEmbeddedSession(const EmbeddedOptions& embedded,
                                                     const SessionOptions& options) {
  if (Status status = ValidateSessionOptions(options); !status.ok()) return status;
  return std::unique_ptr<Session>(std::make_unique<EmbeddedSession>(embedded, options));
}

}  // namespace sweepstake
