// The resume token of a session appears in nothing that the daemon writes.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "absl/strings/escaping.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

v1::StreamTelemetryRequest Hello() {
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.set_protocol_version(1);
  hello.set_project("game");
  hello.set_scene("harbour");
  v1::Arm& arm = *hello.add_arms();
  arm.set_name("Grid");
  arm.set_backend_version(1);
  hello.set_mode(v1::MODE_AI);
  return request;
}

// Opens a session and another one that resumes it, and says goodbye. Returns the token.
std::string Play(const std::string& address) {
  const auto stub = v1::TelemetryService::NewStub(
      grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  v1::StreamTelemetryRequest hello = Hello();
  v1::StreamTelemetryResponse response;
  for (const bool resumed : {false, true}) {
    grpc::ClientContext context;
    const auto stream = stub->StreamTelemetry(&context);
    stream->Write(hello);
    EXPECT_TRUE(stream->Read(&response));
    EXPECT_EQ(response.welcome().resumed(), resumed);
    hello.mutable_hello()->set_session_id(response.welcome().session_id());
    hello.mutable_hello()->set_resume_token(response.welcome().resume_token());
    // A message makes the daemon store the session in the database.
    v1::StreamTelemetryRequest message;
    message.set_sequence(1);
    message.mutable_mode_change()->set_mode(v1::MODE_AI);
    v1::StreamTelemetryRequest goodbye;
    goodbye.mutable_goodbye();
    if (resumed) {
      EXPECT_TRUE(stream->Write(message) && stream->Write(goodbye));
    }
    stream->WritesDone();
    while (stream->Read(&response)) continue;
    EXPECT_TRUE(stream->Finish().ok());
  }
  return hello.hello().resume_token();
}

TEST(ResumeTokenTest, AppearsInNoFileOrLogOfTheDaemon) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path(), "127.0.0.1:0", {"--log-level", "trace"});
  const std::string token = Play(daemon.address());
  ASSERT_EQ(token.size(), 32U);
  EXPECT_EQ(daemon.Terminate(), 0);
  size_t file_count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data.path())) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string content(std::istreambuf_iterator<char>(file), {});
    for (const std::string& text :
         {token, absl::BytesToHexString(token), absl::Base64Escape(token)}) {
      EXPECT_EQ(content.find(text), std::string::npos) << entry.path();
    }
    ++file_count;
  }
  EXPECT_GE(file_count, 3U) << "database, log and key";
  const auto key = std::filesystem::status(data.path() / "resume-key");
  EXPECT_EQ(key.permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

}  // namespace
}  // namespace sweepstake::test_support
