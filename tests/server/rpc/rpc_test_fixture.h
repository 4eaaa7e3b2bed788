// A real server on an ephemeral loopback port, with a manual clock and a client. The store is in
// memory unless a test chooses another.
#pragma once

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "engine_client/telemetry/daemon_channel.h"
#include "server/rpc/rpc_server.h"
#include "server/storage/sqlite_prior_store.h"
#include "server/storage/store_thread.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"
#include "tests/server/rpc/holding_store.h"
#include "tests/server/rpc/log_text.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::rpc {

inline constexpr int64_t kSecondNs = 1'000'000'000;

// Waits until another thread has made the condition true.
template <typename Condition>
[[nodiscard]] bool Eventually(Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

inline v1::Hello HelloMessage() {
  v1::Hello hello;
  hello.set_protocol_version(protocol::kVersion);
  hello.set_project("game");
  hello.set_scene("harbour");
  for (const char* name : {"Grid", "SAP", "KDTree"}) {
    v1::Arm& arm = *hello.add_arms();
    arm.set_name(name);
    arm.set_backend_version(1);
  }
  hello.set_mode(v1::MODE_AI);
  hello.set_policy("paper");
  hello.set_seed(7);
  return hello;
}

// With one arm there is nothing to switch to, so no switch command arrives between other responses.
inline v1::Hello OneArmHello() {
  v1::Hello hello = HelloMessage();
  hello.mutable_arms()->DeleteSubrange(1, 2);
  return hello;
}

// The evidence of games with OneArmHello() after about three hours.
inline priors::PriorRecord LearntInHours() {
  const v1::Hello hello = OneArmHello();
  return {.key = {.project = hello.project(),
                  .scene = hello.scene(),
                  .measured_by = "",
                  .arm = hello.arms(0).name(),
                  .backend_version = hello.arms(0).backend_version(),
                  .machine_class = hello.machine_class(),
                  .reward_version = 1},
          .source_id = "others",
          .source_sequence = 1,
          .evidence = {.alpha = 9'000, .beta = 1'000, .window_count = 10'000, .bail_out_count = 0}};
}

// Changes the Hello so that it resumes the session.
inline void Resume(v1::Hello& hello, const v1::Welcome& session) {
  hello.set_session_id(session.session_id());
  hello.set_resume_token(session.resume_token());
}

inline v1::StreamTelemetryRequest Request(const v1::Hello& hello) {
  v1::StreamTelemetryRequest request;
  *request.mutable_hello() = hello;
  return request;
}

// Returns `count` equal frames of `frame_ms` on `arm`.
inline v1::StreamTelemetryRequest Frames(uint64_t sequence, int count, uint64_t frame_ms = 10,
                                         uint32_t arm = 0, uint32_t epoch = 0) {
  v1::StreamTelemetryRequest request;
  request.set_sequence(sequence);
  v1::FrameBatch& batch = *request.mutable_frame_batch();
  for (int i = 0; i < count; ++i) {
    batch.add_frame_time_ns(frame_ms * 1'000'000);
    batch.add_detection_time_ns(frame_ms * 500'000);
    batch.add_aabb_check_count(1000);
    batch.add_native_bytes(1 << 20);
    batch.add_object_count(100);
    batch.add_arm(arm);
    batch.add_switch_epoch(epoch);
    batch.add_flags(0);
  }
  return request;
}

inline v1::StreamTelemetryRequest BailOut(uint64_t sequence, uint64_t frame_index) {
  v1::StreamTelemetryRequest request;
  request.set_sequence(sequence);
  v1::BailOut& bail_out = *request.mutable_bail_out();
  bail_out.set_frame_index(frame_index);
  bail_out.set_frame_time_ns(6 * kSecondNs);
  bail_out.set_detection_time_ns(5 * kSecondNs);
  bail_out.set_flags(v1::FRAME_FLAG_BAIL_OUT);
  return request;
}

inline v1::StreamTelemetryRequest Goodbye() {
  v1::StreamTelemetryRequest request;
  request.mutable_goodbye();
  return request;
}

// One stream, used by one thread.
class TelemetryClient {
 public:
  using Response = v1::StreamTelemetryResponse;

  explicit TelemetryClient(const std::shared_ptr<grpc::Channel>& channel,
                           const std::string& token = "")
      : stub_(v1::TelemetryService::NewStub(channel)) {
    if (!token.empty()) context_.AddMetadata("authorization", "Bearer " + token);
    stream_ = stub_->StreamTelemetry(&context_);
  }
  ~TelemetryClient() { context_.TryCancel(); }

  bool Send(const v1::StreamTelemetryRequest& request) { return stream_->Write(request); }
  std::optional<Response> Read() {
    Response response;
    if (!stream_->Read(&response)) return std::nullopt;
    if (response.has_acknowledgement()) acknowledged_ = response.acknowledgement().sequence();
    return response;
  }
  // Returns the next response that has the field, and skips others. Fails the test if the stream
  // ends.
  Response Await(bool (Response::*has)() const) {
    while (std::optional<Response> response = Read()) {
      if (((*response).*has)()) return *response;
    }
    ADD_FAILURE() << "the stream ended: " << stream_->Finish().error_message();
    return {};
  }
  v1::Welcome Open(const v1::Hello& hello) {
    Send(Request(hello));
    return Await(&Response::has_welcome).welcome();
  }
  // Waits until `sequence` is acknowledged, and returns the latest acknowledged number.
  // Acknowledgements that Await skipped count.
  uint64_t AwaitAcknowledgement(uint64_t sequence) {
    while (acknowledged_ < sequence && !::testing::Test::HasFailure()) {
      Await(&Response::has_acknowledgement);
    }
    return acknowledged_;
  }
  // Reads until the stream ends, and returns its status.
  grpc::Status Finish() {
    while (Read()) {
    }
    return stream_->Finish();
  }
  void HalfClose() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }

 private:
  uint64_t acknowledged_ = 0;
  grpc::ClientContext context_;
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse>>
      stream_;
};

class RpcTest : public ::testing::Test {
 protected:
  explicit RpcTest(std::unique_ptr<priors::PriorStore> store = *storage::OpenMemoryPriorStore(),
                   std::unique_ptr<storage::ReadConnection> reads = nullptr)
      : thread_(std::move(store), {.group_interval = std::chrono::milliseconds(0)},
                std::move(reads)) {
    // Without exploration and settling, windows are learnt from the first tick on.
    options_.decision.explore = false;
    options_.decision.settling_ns = 0;
    options_.daemon_version = "0.1.0";
    options_.resume_secret = std::string(32, 's');
    options_.max_reads_per_s = 1'000'000;  // tests poll while the clock stands still
  }
  void SetUp() override { StartServer(); }
  void TearDown() override { StopServer(); }

  std::string address() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  // Returns a new connection with small receive windows, so that unread data block the sender soon.
  std::shared_ptr<grpc::Channel> SmallWindowChannel() const {
    grpc::ChannelArguments small_window;
    small_window.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    return grpc::CreateCustomChannel(address(), grpc::InsecureChannelCredentials(), small_window);
  }
  void StartServer() {
    auto server = RpcServer::Start("127.0.0.1:0", options_, clock_, store_, log_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    channel_ = grpc::CreateChannel(address(), grpc::InsecureChannelCredentials());
  }
  // Stops the server; everything outside the store is lost, as after a crash. Expects that every
  // error so far had a reason.
  void StopServer() {
    channel_.reset();
    if (server_ != nullptr) {
      EXPECT_EQ(server_->counters().error_counts.at(v1::ERROR_REASON_UNSPECIFIED), 0u);
    }
    if (server_ != nullptr) server_->Drain(std::chrono::milliseconds(0));
    // Callbacks of the store use the server's loop, and tasks of the loop, including the last ones,
    // call the store. So the store is closed first, as in the daemon.
    store_.Release();
    store_.Close(true);
    Flush();
    server_.reset();
    store_.Close(false);
  }
  void RestartServer() {
    StopServer();
    StartServer();
  }
  void Flush() {
    std::promise<void> done;
    thread_.Submit([&](priors::PriorStore&) { done.set_value(); });
    done.get_future().wait();
  }

  // Writes records into the store directly.
  void Put(const std::vector<priors::PriorRecord>& records) {
    thread_.Submit(
        [&](priors::PriorStore& store) { EXPECT_TRUE(store.Import(records).status().ok()); });
    Flush();
  }

  // Waits until the server has applied `count` messages with evidence since it started.
  [[nodiscard]] bool Applied(uint64_t count) {
    return Eventually([&] { return server_->counters().applied_message_count == count; });
  }
  // Opens a session, sends one window in message 1, and returns the welcome message once message 1
  // is acknowledged. REQUIRES: this is the first session of the server.
  v1::Welcome LearnOneWindow(TelemetryClient& client, const v1::Hello& hello) {
    v1::Welcome welcome = client.Open(hello);
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(1));
    Tick();
    client.AwaitAcknowledgement(1);
    return welcome;
  }
  // Returns the audit rows that the token "NAME-token" may read.
  std::vector<decision::AuditRow> ExportAudit(const v1::ExportDecisionsRequest& request = {},
                                              const std::string& name = "all") {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + name + "-token");
    const auto reader = v1::AuditService::NewStub(channel_)->ExportDecisions(&context, request);
    std::vector<decision::AuditRow> rows;
    for (v1::ExportDecisionsResponse part; reader->Read(&part);)
      std::transform(part.rows().begin(), part.rows().end(), std::back_inserter(rows),
                     [](const v1::AuditRow& row) { return sweepstake::FromProto(row); });
    EXPECT_TRUE(reader->Finish().ok());
    return rows;
  }
  // Returns the actions of administrators that this token may read, as sentences.
  std::vector<std::string> AdminRows(const std::string& name = "all") {
    v1::ExportDecisionsRequest request;
    request.mutable_filter()->set_session_id(std::string(decision::kAdminSession));
    std::vector<std::string> sentences;
    for (const decision::AuditRow& row : ExportAudit(request, name))
      sentences.push_back(row.operator_name + " " + row.action);
    return sentences;
  }
  // Makes one decision tick; the caller waits for its results.
  void Tick() { clock_.Advance(options_.decision.decision_interval_ns); }

  priors::SceneEvidence Stored(const std::string& scene = "harbour", uint32_t reward_version = 1) {
    std::promise<priors::SceneEvidence> result;
    thread_.Submit([&](priors::PriorStore& store) {
      result.set_value(
          store.LoadScene({"game", scene, "", reward_version})->value_or(priors::SceneEvidence{}));
    });
    return result.get_future().get();
  }

  RpcOptions options_;
  sessions::ManualClock clock_;
  const std::shared_ptr<LogText> logged_ = std::make_shared<LogText>();
  spdlog::logger log_{"test", logged_};
  storage::StoreThread thread_;
  HoldingStore store_{thread_};
  std::unique_ptr<RpcServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace sweepstake::rpc
