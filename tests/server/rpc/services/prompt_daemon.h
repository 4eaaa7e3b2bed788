// The streams of a daemon without gRPC and threads: each call takes effect before it returns. For
// tests with many streams, or with streams of other machines.
#pragma once

#include <spdlog/logger.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/rpc/common/event_encoder.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/rpc/services/telemetry_stream.h"
#include "server/sessions/session_table.h"
#include "tests/server/sessions/manual_clock.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::rpc {

// Answers at once, on the caller's thread, except for held reads.
class PromptStore final : public priors::AsyncPriorStore {
 public:
  void Commit(priors::SourceUpdate update, CommitCallback done) override {
    const absl::Status status = store.Commit({&update, 1});
    if (status.ok()) committed_.push_back(std::move(update));
    done(status);
  }
  bool Submit(Job job) override {
    job(store);
    return true;
  }
  bool Read(ReadJob job) override {
    if (!holds_reads_) {
      job(store);
    } else {
      auto state = std::make_unique<storage::ForwardingStore>();
      if (!state->Commit(committed_).ok()) std::abort();
      held_.emplace_back(std::move(state), std::move(job));
    }
    return true;
  }
  // Reads that begin before EndReads see the state at their start. Their results are delivered at
  // EndReads.
  void HoldReads() { holds_reads_ = true; }
  void EndReads() {
    holds_reads_ = false;
    for (auto& [state, job] : std::exchange(held_, {})) job(*state);
  }
  bool healthy() const override { return true; }
  priors::StoreLosses losses() const override { return store.losses(); }

  storage::ForwardingStore store;

 private:
  bool holds_reads_ = false;
  std::vector<priors::SourceUpdate> committed_;
  std::vector<std::pair<std::unique_ptr<priors::PriorStore>, ReadJob>> held_;
};

struct PromptDaemon {
  explicit PromptDaemon(RpcOptions wanted = {}) : options(std::move(wanted)) {
    options.daemon_version = "test";
    options.resume_secret = std::string(32, 's');
  }
  void Advance(int64_t by_ns) {
    clock.Advance(by_ns);
    loop.RunReady();
  }

  RpcOptions options;
  sessions::ManualClock clock;
  PromptStore store;
  Counters counters;
  spdlog::logger log{"test"};
  sessions::DecisionLoop loop{clock, {}, sessions::DecisionLoop::Runner::kCaller};
  EventEncoder encoder;
  events::EventBus events{store, loop, sessions, encoder};
  sessions::SessionTable sessions{{options, loop, store, counters, events}};
  StallSweep stalls{loop, options.watcher_patience_ns};
  AccessControl access{options, clock, log};
  sessions::AdminLog admin{options, loop, store, counters};
  alerts::AlertMonitor alerts{options.alerts, loop, sessions};
  ServiceContext context{options, loop,   store, counters, events, sessions,
                         stalls,  access, log,   admin,    alerts};
  TelemetryStreams streams;
};

// A client's stream. It reads all responses, and closes when it is destroyed.
class PromptStream final : public TelemetryTransport {
 public:
  explicit PromptStream(PromptDaemon& daemon, std::string peer = "ipv4:127.0.0.1:1",
                        auth::Principal caller = {})
      : daemon_(daemon), peer_(std::move(peer)) {
    stream_ =
        std::make_shared<TelemetryStream>(daemon.context, daemon.streams, *this, std::move(caller));
    stream_->Accept();
    daemon.loop.RunReady();
  }
  ~PromptStream() override { Leave(); }

  // Returns whether the stream is still open.
  bool Send(v1::StreamTelemetryRequest request) {
    if (stream_ == nullptr || pending_reads_ == 0) return false;
    --pending_reads_;
    stream_->OnMessage(&request);
    daemon_.loop.RunReady();
    return stream_ != nullptr;
  }
  void Leave() {
    if (stream_ != nullptr) Cancel(absl::OkStatus());
    daemon_.loop.RunReady();
  }
  bool welcomed() const { return !written_.empty() && written_.front().has_welcome(); }
  const std::vector<v1::StreamTelemetryResponse>& written() const { return written_; }
  uint32_t pending_reads() const { return pending_reads_; }
  // The status with which the daemon has ended the stream.
  const std::optional<absl::Status>& end() const { return end_; }

  void Read() override {
    if (++pending_reads_ > kMaxReads) std::abort();
  }
  void Write(const v1::StreamTelemetryResponse& response) override {
    written_.push_back(response);
    Post([this] { stream_->OnWritten(true); });
  }
  void Finish(const absl::Status& status) override {
    end_ = status;
    if (std::exchange(pending_reads_, 0) > 0) Post([this] { stream_->OnHalfClose(); });
    Post([this] {
      stream_->OnDone();
      stream_.reset();
    });
  }
  void Cancel(const absl::Status& /*status*/) override {
    if (std::exchange(pending_reads_, 0) > 0) Post([this] { stream_->OnHalfClose(); });
    Post([this] { stream_->OnCancelled(); });
  }
  std::string peer() const override { return peer_; }

 private:
  template <typename Event>
  void Post(Event event) {
    daemon_.loop.Post([this, event] {
      if (stream_ != nullptr) event();
    });
  }

  PromptDaemon& daemon_;
  const std::string peer_;
  std::shared_ptr<TelemetryStream> stream_;
  uint32_t pending_reads_ = 0;
  std::vector<v1::StreamTelemetryResponse> written_;
  std::optional<absl::Status> end_;
};

}  // namespace sweepstake::rpc
