#include "server/rpc/services/telemetry_service.h"

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/stall_sweep.h"

namespace sweepstake::rpc {
namespace {

// Transports a TelemetryStream over gRPC.
//
// gRPC's callbacks run on gRPC's threads. They only parse messages and post tasks to the decision
// loop. This class parses the messages itself, into reused memory: gRPC would report a message that
// does not parse as an orderly half-close. The object deletes itself after OnDone.
class TelemetryCall final : public grpc::ServerGenericBidiReactor, public TelemetryTransport {
 public:
  TelemetryCall(ServiceContext& context, TelemetryStreams& streams,
                grpc::CallbackServerContext& call, const Caller& caller)
      : loop_(context.loop),
        counters_(context.counters),
        call_(call),
        peer_(caller.peer),
        stream_(std::make_shared<TelemetryStream>(context, streams, *this, caller)) {
    loop_.Post([this] { stream_->Accept(); });
  }

  void Read() override {
    if (wanted_reads_.fetch_add(1) == 0) StartRead(&read_bytes_);
  }
  void Write(const v1::StreamTelemetryResponse& response) override {
    write_bytes_ = Serialize(response);
    StartWrite(&write_bytes_);
  }
  void Finish(const absl::Status& status) override {
    grpc::ServerGenericBidiReactor::Finish(ToGrpc(status, counters_));
  }
  void Cancel(const absl::Status& status) override {
    rpc::Cancel(call_, ToGrpc(status, counters_));
  }
  std::string peer() const override { return peer_; }

  void OnReadDone(bool ok) override {
    if (!ok) return loop_.Post([this] { stream_->OnHalfClose(); });
    v1::StreamTelemetryRequest& request = requests_[read_count_++ % requests_.size()];
    const bool parsed = Parse(read_bytes_, request);
    // Post this message before wanted_reads_ is decremented. After that, the loop may start the
    // next read, and its message must not overtake this one.
    loop_.Post([this, &request, parsed] { stream_->OnMessage(parsed ? &request : nullptr); });
    if (wanted_reads_.fetch_sub(1) > 1) StartRead(&read_bytes_);
  }
  void OnWriteDone(bool ok) override {
    write_bytes_.Clear();
    loop_.Post([this, ok] { stream_->OnWritten(ok); });
  }
  void OnCancel() override {
    loop_.Post([this] { stream_->OnCancelled(); });
  }
  // Deletes the object in a task, because tasks that were posted before still use it.
  void OnDone() override {
    loop_.Post([this] {
      stream_->OnDone();
      delete this;
    });
  }

 private:
  // gRPC returns from OnReadDone before it calls OnDone. ThreadSanitizer cannot see this order; the
  // load of the atomic makes it visible.
  ~TelemetryCall() override { wanted_reads_.load(); }

  sessions::DecisionLoop& loop_;
  Counters& counters_;
  grpc::CallbackServerContext& call_;
  const std::string peer_;
  const std::shared_ptr<TelemetryStream> stream_;

  // Number of Read() calls that have not received a message. While it is above 0, a gRPC read is
  // pending, until the client half-closes.
  std::atomic<uint32_t> wanted_reads_{0};
  grpc::ByteBuffer read_bytes_;  // read_bytes_ and read_count_ are used by gRPC's callback
  uint64_t read_count_ = 0;
  // Two request buffers, used alternately: gRPC's callback fills one while the loop applies the
  // other.
  std::array<v1::StreamTelemetryRequest, TelemetryTransport::kMaxReads> requests_;
  grpc::ByteBuffer write_bytes_;  // used on the loop, and by gRPC while a write is pending
};

}  // namespace

grpc::ServerGenericBidiReactor* TelemetryService::Serve(grpc::CallbackServerContext& call,
                                                        const Caller& caller) {
  return new TelemetryCall(context_, streams_, call, caller);
}

}  // namespace sweepstake::rpc
