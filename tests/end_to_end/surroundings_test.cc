// A daemon with closed standard streams, or with a limit on the size of its files, as a shell or a
// service manager may start it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

#ifdef __linux__
#include <sys/resource.h>

namespace sweepstake::test_support {
namespace {

namespace fs = std::filesystem;

// Sets the soft limit of the size of files that the process writes.
void LimitFiles(pid_t process, rlim_t bytes) {
  rlimit limit{};
  ASSERT_EQ(prlimit(process, RLIMIT_FSIZE, nullptr, &limit), 0);
  limit.rlim_cur = bytes;
  ASSERT_EQ(prlimit(process, RLIMIT_FSIZE, &limit, nullptr), 0);
}

void StoreFirstFrames(rpc::TelemetryClient& game) {
  v1::Hello hello = rpc::OneArmHello();
  hello.set_time_scale(200);
  game.Open(hello);
  game.Send(rpc::Frames(1, 30));
  game.AwaitAcknowledgement(1);
}

TEST(SurroundingsTest, AtALimitOfFileSizesTheDaemonWaitsAsOnAFullDisk) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path(), "127.0.0.1:0", {"--http", "127.0.0.1:0"});
  rpc::TelemetryClient game(
      grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials()));
  StoreFirstFrames(game);
  const auto is_ready = [&] { return Get(daemon.http_port(), "/readyz").status == 200; };
  EXPECT_TRUE(is_ready());

  LimitFiles(daemon.pid(), 1);
  game.Send(rpc::Frames(2, 30));
  EXPECT_TRUE(rpc::Eventually([&] { return !is_ready(); }));
  EXPECT_FALSE(daemon.ended());
  LimitFiles(daemon.pid(), RLIM_INFINITY);
  game.AwaitAcknowledgement(2);
  EXPECT_TRUE(rpc::Eventually(is_ready));
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST(SurroundingsTest, ACutMappedFileEndsTheDaemonWithAMessage) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  rpc::TelemetryClient game(
      grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials()));
  StoreFirstFrames(game);
  fs::resize_file(data.path() / "priors.db-shm", 0);
  game.Send(rpc::Frames(2, 30));
  EXPECT_TRUE(rpc::Eventually([&] { return daemon.ended(); }));
  EXPECT_NE(daemon.log().find("was cut while it was in use"), std::string::npos) << daemon.log();
}

// SQLite opens such a database as if nothing were missing.
TEST(SurroundingsTest, ARemovedWriteAheadLogIsReported) {
  const TemporaryDirectory data;
  {
    DaemonProcess daemon(data.path());
    rpc::TelemetryClient game(
        grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials()));
    StoreFirstFrames(game);
    uint64_t marked = 0;
    EXPECT_TRUE(rpc::Eventually(
        [&] { return std::ifstream(data.path() / "store-commits") >> marked && marked > 0; }));
    daemon.Kill();
  }
  {
    DaemonProcess daemon(data.path());
    EXPECT_EQ(daemon.log().find("lacks"), std::string::npos) << "a kill alone loses nothing";
    daemon.Kill();
  }
  fs::remove(data.path() / "priors.db-wal");
  fs::remove(data.path() / "priors.db-shm");
  DaemonProcess daemon(data.path());
  EXPECT_NE(daemon.log().find("commits that it had before"), std::string::npos) << daemon.log();
}

TEST(SurroundingsTest, ClosedStandardStreamsAreNotFilesOfTheData) {
  const TemporaryDirectory data;
  const fs::path port_file = data.path() / "port";
  ChildProcess daemon(
      {"sh", "-c",
       "exec " SWEEPSTAKED_PATH " --listen 127.0.0.1:0 --port-file " + port_file.string() +
           " --data " + (data.path() / "d").string() + " <&- >&- 2>&-"},
      data.path() / "log");
  ASSERT_TRUE(rpc::Eventually([&] { return fs::exists(port_file); })) << daemon.log();
  // gRPC opens a descriptor before `main`, which may have become number 0.
  for (const char* stream : {"1", "2"}) {
    const fs::path open = fs::path("/proc") / std::to_string(daemon.pid()) / "fd" / stream;
    EXPECT_EQ(fs::read_symlink(open), "/dev/null") << stream;
  }
  EXPECT_EQ(daemon.Terminate(), 0);
}

}  // namespace
}  // namespace sweepstake::test_support
#endif
