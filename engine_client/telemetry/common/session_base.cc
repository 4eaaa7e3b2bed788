#include "engine_client/telemetry/common/session_base.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake {

SessionBase::SessionBase(const SessionOptions& options)
    : flight_(options.flight_recorder.memory_mb > 0 ? MakeThreadOwned<FlightRecorder>(options)
                                                    : nullptr),
      queue_(std::make_shared<SampleQueue>(
          options.queue_frames,
          flight_ ? std::shared_ptr<FlightRing>(flight_, &flight_->ring()) : nullptr)) {}

Status SessionBase::Start(AdaptiveBroadPhase& adaptive) {
  const FloatEnvironmentScope environment;
  if (adaptive_.load() != nullptr || stats().state == ConnectionState::kClosed) {
    return {StatusCode::kFailedPrecondition, "the session was already started: make a new one"};
  }
  if (!adaptive.Attach(attachment_)) {
    return {StatusCode::kFailedPrecondition,
            "another session uses this AdaptiveBroadPhase: stop that session first"};
  }
  if (Status status = Prepare(adaptive); !status.ok()) {
    adaptive.Attach(nullptr);
    return status;
  }
  adaptive_.store(&adaptive);
  Status started = StartThread();
  if (started.ok()) {
    attachment_->Begin([this](uint32_t deadline_ms) { EndThread(deadline_ms); },
                       [this](uint32_t deadline_ms) { LimitStop(deadline_ms); });
  } else {
    adaptive_.store(nullptr);
    adaptive.Attach(nullptr);
  }
  return started;
}

Status SessionBase::StartThread() {
  return CatchFailure(
      [&]() -> Status {
        const std::chrono::microseconds pause = poll_interval();
        thread_.Start(pause, [this, pause](bool stopping) {
          if (flight_) flight_->Step(this->adaptive());
          return Step(stopping) ? std::optional(pause) : std::nullopt;
        });
        return {};
      },
      [](const char*) -> Status {
        return {StatusCode::kResourceExhausted,
                "the system cannot start a thread for the session: end other threads"};
      });
}

void SessionBase::LimitStop(uint32_t deadline_ms) {
  const uint64_t deadline_ns = SteadyClock().NowNs() + uint64_t{deadline_ms} * 1'000'000;
  stop_deadline_ns_.store(std::min(stop_deadline_ns_.load(), deadline_ns));
}

// A second Stop with an earlier deadline shortens the first one.
void SessionBase::Stop(uint32_t deadline_ms) {
  LimitStop(deadline_ms);
  attachment_->End(deadline_ms);
  Close();
}

void SessionBase::EndThread(uint32_t deadline_ms) {
  LimitStop(deadline_ms);
  thread_.RequestStop();
  thread_.Join();
  AdaptiveBroadPhase* const adaptive = adaptive_.exchange(nullptr);
  adaptive->SetDeciderPresent(false);
  adaptive->SetLaneUse(true);
  Close();
}

// Does nothing in a forked child, where the parent's thread may hold the lock for ever.
void SessionBase::Close() {
  if (thread_.is_in_child()) return;
  UpdateStats([](SessionStats& stats) { stats.state = ConnectionState::kClosed; });
}

Result<std::string> SessionBase::ExportPriors() const {
  return Status(StatusCode::kFailedPrecondition,
                "the daemon stores what this session learns: use `sweepstake priors export`");
}

SessionStats SessionBase::stats() const {
  const std::lock_guard lock(stats_mutex_);
  SessionStats stats = *stats_;
  stats.dropped_frame_count += queue_->dropped_frame_count();
  if (flight_) {
    stats.recordings = flight_->recordings();
    stats.recording_error = flight_->error();
  }
  return stats;
}

}  // namespace sweepstake
