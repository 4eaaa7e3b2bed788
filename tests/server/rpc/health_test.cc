// Tests grpc.health.v1 with gRPC's generic client.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/impl/codegen/client_callback.h>

#include <memory>
#include <string>
#include <vector>

#include "server/rpc/health_service.h"
#include "tests/server/rpc/http2_frames.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::rpc {
namespace {

using test_support::HttpSocket;

constexpr char kCheck[] = "/grpc.health.v1.Health/Check";
constexpr char kWatch[] = "/grpc.health.v1.Health/Watch";
constexpr char kServing[] = "\x08\x01", kNotServing[] = "\x08\x02", kUnknown[] = "\x08\x03";

// A call of a health method. `name` is the field `service` of the request.
class HealthCall {
 public:
  HealthCall(const std::shared_ptr<grpc::Channel>& channel, const char* method,
             const std::string& name = "")
      : method_(method, grpc::internal::RpcMethod::BIDI_STREAMING, channel),
        stream_(
            grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
                channel.get(), method_, &context_)) {
    const std::string bytes =
        name.empty() ? "" : std::string("\x0A") + static_cast<char>(name.size()) + name;
    const grpc::Slice slice(bytes);
    stream_->Write(grpc::ByteBuffer(&slice, 1));
    stream_->WritesDone();
  }
  ~HealthCall() { context_.TryCancel(); }

  // Returns the next response; "end" if there is none.
  std::string Read() {
    grpc::ByteBuffer response;
    if (!stream_->Read(&response)) return "end";
    grpc::Slice slice;
    EXPECT_TRUE(response.DumpToSingleSlice(&slice).ok());
    return {reinterpret_cast<const char*>(slice.begin()), slice.size()};
  }
  grpc::StatusCode End() { return stream_->Finish().error_code(); }

 private:
  grpc::ClientContext context_;
  grpc::internal::RpcMethod method_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
};

class HealthTest : public RpcTest {};

TEST_F(HealthTest, ChecksTheWholeDaemonOnly) {
  HealthCall whole(channel_, kCheck);
  EXPECT_EQ(whole.Read(), kServing);
  EXPECT_EQ(whole.Read(), "end");
  EXPECT_EQ(whole.End(), grpc::StatusCode::OK);
  HealthCall other(channel_, kCheck, "other");
  EXPECT_EQ(other.Read(), "end");
  EXPECT_EQ(other.End(), grpc::StatusCode::NOT_FOUND);
  HealthCall no_method(channel_, "/grpc.health.v1.Health/List");
  EXPECT_EQ(no_method.Read(), "end");
  EXPECT_EQ(no_method.End(), grpc::StatusCode::UNIMPLEMENTED);
}

TEST_F(HealthTest, AWatchReportsTheDrainAndEndsWithTheServer) {
  HealthCall watch(channel_, kWatch);
  EXPECT_EQ(watch.Read(), kServing);
  HealthCall unknown(channel_, kWatch, "other");
  EXPECT_EQ(unknown.Read(), kUnknown);
  server_->Drain(std::chrono::milliseconds(100));
  EXPECT_EQ(watch.Read(), kNotServing);
  EXPECT_EQ(watch.Read(), "end");
  EXPECT_NE(watch.End(), grpc::StatusCode::OK);
}

// A call that ends before its request has arrived must be finished once.
TEST_F(HealthTest, CallsWithoutARequestEnd) {
  for (int i = 0; i < 20; ++i) {
    HttpSocket socket(server_->port());
    socket.Send(test_support::Http2Preface() + test_support::Http2Call(1, kWatch) +
                test_support::Http2Call(3, kCheck));
    if (i % 2 == 0) socket.Send(test_support::Http2Reset(1) + test_support::Http2Reset(3));
  }
  EXPECT_EQ(HealthCall(channel_, kCheck).Read(), kServing);
}

TEST_F(HealthTest, WatchesAreLimited) {
  options_.max_streams_per_connection = 1'000;
  RestartServer();
  std::vector<std::unique_ptr<HealthCall>> watches;
  for (size_t i = 0; i < HealthService::kMaxWatches; ++i) {
    watches.push_back(std::make_unique<HealthCall>(channel_, kWatch));
    ASSERT_EQ(watches.back()->Read(), kServing);
  }
  HealthCall beyond(channel_, kWatch);
  EXPECT_EQ(beyond.Read(), "end");
  EXPECT_EQ(beyond.End(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(HealthCall(channel_, kCheck).Read(), kServing);
  watches.pop_back();
  EXPECT_TRUE(Eventually([&] { return HealthCall(channel_, kWatch).Read() == kServing; }));
}

}  // namespace
}  // namespace sweepstake::rpc
