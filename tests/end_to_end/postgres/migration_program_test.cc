// `sweepstaked migrate` transfers what a daemon has learnt to PostgreSQL and back, and its sessions
// continue in both places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/wait.h>

#include <memory>
#include <string>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/postgres/postgres_server.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMessages = 5;

struct Ran {
  int exit_code = -1;
  std::string said;  // output on stdout and stderr
};

Ran RunDaemonProgram(const std::string& arguments) {
  Ran ran;
  FILE* pipe = popen((SWEEPSTAKED_PATH " " + arguments + " 2>&1").c_str(), "r");
  char buffer[4096];
  for (size_t size; (size = fread(buffer, 1, sizeof(buffer), pipe)) > 0;)
    ran.said.append(buffer, size);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ran.exit_code = WEXITSTATUS(status);
  return ran;
}

std::shared_ptr<grpc::Channel> To(const DaemonProcess& daemon) {
  return grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials());
}

// Returns the posteriors of the only scene after its sessions have ended.
std::string PosteriorsOf(const DaemonProcess& daemon) {
  const auto stub = v1::PosteriorsService::NewStub(To(daemon));
  v1::ListPosteriorsResponse response;
  EXPECT_TRUE(rpc::Eventually([&] {
    grpc::ClientContext context;
    EXPECT_TRUE(stub->ListPosteriors(&context, {}, &response).ok());
    return response.scenes_size() == 1 && response.scenes(0).active_session_count() == 0;
  }));
  return response.ShortDebugString();
}

class MigrationProgram : public ::testing::Test {
 protected:
  MigrationProgram() { hello_.set_time_scale(200); }

  // Sends the messages from + 1 to `until` and waits until they are acknowledged. Then says
  // goodbye, unless `from` is 0.
  void Play(const DaemonProcess& daemon, uint64_t from, uint64_t until) {
    rpc::TelemetryClient game(To(daemon));
    const v1::Welcome welcome = game.Open(hello_);
    EXPECT_EQ(welcome.acknowledged_sequence(), from);
    if (from > 0) {
      EXPECT_EQ(welcome.session_id(), hello_.session_id());
    }
    rpc::Resume(hello_, welcome);
    for (uint64_t next = from + 1; next <= until; ++next) {
      game.Send(next == 1 ? rpc::BailOut(1, 1000) : rpc::Frames(next, 30));
    }
    game.AwaitAcknowledgement(until);
    if (from == 0) return;
    game.Send(rpc::Goodbye());
    EXPECT_TRUE(game.Finish().ok());
  }
  std::string Paths() const {
    return " --data " + data_.path().string() + " --store '" + url_ + "'";
  }

  PostgresServer server_;
  const std::string url_ = server_.NewDatabase();
  const TemporaryDirectory data_;
  v1::Hello hello_ = rpc::OneArmHello();
};

TEST_F(MigrationProgram, EvidenceMovesThereAndBackAndTheSessionContinues) {
  {
    DaemonProcess daemon(data_.path());
    Play(daemon, 0, kMessages);
    const Ran refused = RunDaemonProgram("migrate to-store" + Paths());
    EXPECT_EQ(refused.exit_code, 1) << "the daemon still runs";
    EXPECT_THAT(refused.said, HasSubstr("another daemon uses the data directory"));
    EXPECT_EQ(daemon.Terminate(), 0);
  }
  const Ran there = RunDaemonProgram("migrate to-store" + Paths());
  EXPECT_EQ(there.exit_code, 0) << there.said;
  EXPECT_THAT(there.said, HasSubstr("sweepstaked: evidence: 1 of 1 rows\n"));
  EXPECT_THAT(there.said, HasSubstr(": undamaged; 1 record of 1 source about 1 scene"));
  const Ran again = RunDaemonProgram("migrate to-store" + Paths());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.said, HasSubstr("already contains evidence; name another database"));
  std::string learnt;
  {
    DaemonProcess daemon(data_.path(), "127.0.0.1:0", {"--store", url_});
    Play(daemon, kMessages, 2 * kMessages);
    learnt = PosteriorsOf(daemon);
    EXPECT_EQ(daemon.Terminate(), 0);
  }
  const auto back = data_.path() / "back";
  const Ran ran =
      RunDaemonProgram("migrate to-data --store '" + url_ + "' --data " + back.string());
  EXPECT_EQ(ran.exit_code, 0) << ran.said;
  DaemonProcess daemon(back);
  EXPECT_EQ(PosteriorsOf(daemon), learnt);
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST(MigrationWords, ErrorsSayWhatIsMissingAndWhatToDo) {
  const TemporaryDirectory directory;
  const std::string data = " --data " + directory.path().string();
  EXPECT_THAT(RunDaemonProgram("migrate to-store" + data).said,
              HasSubstr("name the shared store with --store postgresql://"));
  const Ran nowhere =
      RunDaemonProgram("migrate to-data --store 'postgresql:///none?host=/nowhere'" + data);
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_THAT(nowhere.said, HasSubstr("PostgreSQL cannot be reached: "));
  EXPECT_THAT(nowhere.said, HasSubstr("check that the server runs"));
  EXPECT_EQ(RunDaemonProgram("migrate sideways" + data).exit_code, 2);
  EXPECT_THAT(RunDaemonProgram("migrate --help").said, HasSubstr("sweepstaked migrate to-data"));
  const Ran start = RunDaemonProgram("--store 'postgresql:///none?host=/nowhere'" + data);
  EXPECT_EQ(start.exit_code, 3);
  EXPECT_THAT(start.said, HasSubstr("check that the server runs"));
}

TEST(MigrationWords, TheExampleOfASharedStoreIsAValidConfiguration) {
  const Ran checked = RunDaemonProgram("check-config " EXAMPLE_CONFIG);
  EXPECT_EQ(checked.exit_code, 0) << checked.said;
}

}  // namespace
}  // namespace sweepstake::test_support
