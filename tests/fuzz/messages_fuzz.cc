// Fuzzes the bytes that a game sends through the daemon's own stream to its session, decisions,
// evidence and audit log. Every decision must be derivable from its log, and stored data must be
// valid.
#include <memory>
#include <string>
#include <utility>

#include "engine_client/decider/audit/rederive.h"
#include "server/events/subscriber.h"
#include "server/storage/record_limits.h"
#include "sweepstake/v1/telemetry.pb.h"
#include "tests/engine_client/decider/audit/stored_audit.h"
#include "tests/fuzz/input.h"
#include "tests/server/rpc/services/prompt_daemon.h"

namespace sweepstake::rpc {
namespace {

using fuzz::Input;
using fuzz::Require;

constexpr uint32_t kAll = 1'000'000;
constexpr int64_t kTenthOfSecondNs = 100'000'000;

// Watches all scenes, and takes each event at once.
class Watcher final : public events::Sink {
 public:
  void Begin(std::unique_ptr<events::Subscriber> subscriber) override {
    subscriber_ = std::move(subscriber);
  }
  void Wake() override {
    while (subscriber_ != nullptr && !subscriber_->Take(kAll).empty()) {
    }
  }
  void OnEnd(const absl::Status&) override { subscriber_.reset(); }

 private:
  std::unique_ptr<events::Subscriber> subscriber_;
};

RpcOptions Options() {
  RpcOptions options;
  options.max_time_scale = kMaxTimeScale;
  return options;
}

// A daemon and the connection of its one client, on the fuzzer's thread.
class Daemon final : public TelemetryTransport {
 public:
  Daemon() { daemon_.events.Subscribe({.kind = events::Kind::kPosteriors}, watcher_); }
  ~Daemon() override { LoseConnection(); }

  void Take(std::string_view bytes) {
    if (stream_ == nullptr) Connect();
    if (pending_reads_ == 0) return;
    --pending_reads_;
    const bool parsed = request_.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
    if (parsed && request_.has_hello()) Complete(*request_.mutable_hello());
    stream_->OnMessage(parsed ? &request_ : nullptr);
    daemon_.loop.RunReady();
  }
  void Advance(int64_t by_ns) { daemon_.Advance(by_ns); }
  void LoseConnection() {
    if (stream_ == nullptr) return;
    Cancel(absl::OkStatus());
    daemon_.loop.RunReady();
    Require(stream_ == nullptr, "a lost connection ends its stream");
  }

  void Check() {
    Require(storage::CheckRecords(daemon_.store.store.Export({}, {}, kAll)->records).ok(),
            "stored data is valid");
    const decision::AuditReport report =
        decision::Rederive(*test_support::StoredAudit(daemon_.store.store));
    if (report.difference) Require(false, report.difference->Text());
  }

 private:
  void Connect() {
    pending_reads_ = 0;
    acknowledged_ = 0;
    stream_ = std::make_shared<TelemetryStream>(daemon_.context, daemon_.streams, *this,
                                                auth::Principal{});
    stream_->Accept();
  }
  // Adds the session's id and token, which an input cannot contain, and a seed, so that an input
  // always has the same effect.
  void Complete(v1::Hello& hello) const {
    if (hello.seed() == 0) hello.set_seed(1);
    if (hello.session_id().empty()) return;
    hello.set_session_id(welcome_.session_id());
    hello.set_resume_token(welcome_.resume_token());
  }
  template <typename Event>
  void Post(Event event) {
    daemon_.loop.Post([this, event] {
      if (stream_ != nullptr) event();
    });
  }

  void Read() override { Require(++pending_reads_ <= kMaxReads, "few messages are read ahead"); }
  void Write(const v1::StreamTelemetryResponse& response) override {
    if (response.has_welcome()) {
      welcome_ = response.welcome();
      acknowledged_ = welcome_.acknowledged_sequence();
    }
    if (response.has_acknowledgement()) {
      Require(response.acknowledgement().sequence() > acknowledged_, "acknowledgements grow");
      acknowledged_ = response.acknowledgement().sequence();
    }
    for (const v1::BetaPosterior& posterior : response.posterior_snapshot().arms()) {
      Require(posterior.alpha() > 0 && posterior.alpha() < storage::kMaxEvidence, "alpha is valid");
      Require(posterior.beta() > 0 && posterior.beta() < storage::kMaxEvidence, "beta is valid");
    }
    Post([this] { stream_->OnWritten(true); });
  }
  void Finish(const absl::Status&) override {
    if (std::exchange(pending_reads_, 0) > 0) Post([this] { stream_->OnHalfClose(); });
    Post([this] {
      stream_->OnDone();
      stream_.reset();
    });
  }
  void Cancel(const absl::Status&) override {
    if (std::exchange(pending_reads_, 0) > 0) Post([this] { stream_->OnHalfClose(); });
    Post([this] { stream_->OnCancelled(); });
  }
  std::string peer() const override { return "fuzzer"; }

  PromptDaemon daemon_{Options()};
  Watcher watcher_;
  std::shared_ptr<TelemetryStream> stream_;
  uint32_t pending_reads_ = 0;
  v1::StreamTelemetryRequest request_;
  v1::Welcome welcome_;
  uint64_t acknowledged_ = 0;
};

void Run(Input input) {
  Daemon daemon;
  while (!input.empty()) {
    const uint8_t step = input.Byte();
    if (step == 0xff) {
      daemon.LoseConnection();
    } else if (step >= 0x80) {
      daemon.Advance((step - 0x80) * kTenthOfSecondNs);
    } else {
      daemon.Take(input.Piece());
    }
  }
  daemon.LoseConnection();
  daemon.Check();
}

}  // namespace
}  // namespace sweepstake::rpc

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::rpc::Run({data, size});
  return 0;
}
