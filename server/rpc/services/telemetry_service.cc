#include "server/rpc/services/telemetry_service.h"

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/rpc/services/unary_call.h"

namespace sweepstake::rpc {
namespace {

// Transports a stream over gRPC.
//
// gRPC's callbacks run on its few threads and only parse and post. Messages are parsed here, from
// raw bytes into reused memory, because gRPC would report an invalid one as an orderly half-close.
// It owns itself until gRPC is done with it.
class TelemetryCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                            public TelemetryTransport {
 public:
  TelemetryCall(ServiceContext& context, TelemetryStreams& streams,
                grpc::CallbackServerContext& call, auth::Principal caller)
      : loop_(context.loop),
        counters_(context.counters),
        call_(call),
        stream_(std::make_shared<TelemetryStream>(context, streams, *this, std::move(caller))) {
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
    ServerBidiReactor::Finish(ToGrpc(status, counters_));
  }
  void Cancel(const absl::Status& status) override {
    rpc::Cancel(call_, ToGrpc(status, counters_));
  }
  std::string peer() const override { return call_.peer(); }

  void OnReadDone(bool ok) override {
    if (!ok) return loop_.Post([this] { stream_->OnHalfClose(); });
    v1::StreamTelemetryRequest& request = requests_[read_count_++ % requests_.size()];
    const bool parsed = Parse(read_bytes_, request);
    // Post first: after the decrement the loop may start the next read, whose message must not
    // overtake this one.
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
  // All earlier tasks have run by then.
  void OnDone() override {
    loop_.Post([this] {
      stream_->OnDone();
      delete this;
    });
  }

 private:
  // gRPC ends OnReadDone before OnDone. This load shows that to ThreadSanitizer.
  ~TelemetryCall() override { wanted_reads_.load(); }

  sessions::DecisionLoop& loop_;
  Counters& counters_;
  grpc::CallbackServerContext& call_;
  const std::shared_ptr<TelemetryStream> stream_;

  // Read() calls without a message yet. While there are some, a read is pending, until the
  // half-close.
  std::atomic<uint32_t> wanted_reads_{0};
  grpc::ByteBuffer read_bytes_;  // these two are used by gRPC's callback
  uint64_t read_count_ = 0;
  // Used alternately: the callback fills one while the loop applies the other.
  std::array<v1::StreamTelemetryRequest, TelemetryTransport::kMaxReads> requests_;
  grpc::ByteBuffer write_bytes_;  // used on the loop, and by gRPC while a write is pending
};

}  // namespace

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* TelemetryService::StreamTelemetry(
    grpc::CallbackServerContext* call) {
  auto caller = context_.access.Authorize(*call, RpcOf("TelemetryService/StreamTelemetry"));
  if (caller.ok()) return new TelemetryCall(context_, streams_, *call, *std::move(caller));
  return new RefusedCall<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>(
      context_, caller.status());
}

}  // namespace sweepstake::rpc
