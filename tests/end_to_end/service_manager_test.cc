// Tests the daemon under a service manager, and its program as a health probe.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tests/server/host/notify_socket.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;

TEST(ServiceManagerTest, ReceivesNotificationsFromStartToEnd) {
  const TemporaryDirectory data;
  const TemporaryDirectory folder;
  NotifySocket manager(folder.path(), std::chrono::seconds(60));
  DaemonProcess daemon(data.path());
  // The watchdog's thread and the main thread send independently, so either may be first.
  std::string first = manager.Receive();
  const bool watchdog_came = first == "WATCHDOG=1";
  if (watchdog_came) first = manager.Receive();
  EXPECT_EQ(first, "READY=1");
  if (!watchdog_came) {
    EXPECT_EQ(manager.Receive(), "WATCHDOG=1") << "the daemon has probed its own listener";
  }
  EXPECT_EQ(daemon.Terminate(), 0);
  std::string last;
  for (std::string next = manager.ReceiveNow(); !next.empty(); next = manager.ReceiveNow())
    last = next == "WATCHDOG=1" ? last : next;
  EXPECT_EQ(last, "STOPPING=1");
}

int Probe(const std::string& arguments) {
  const int status = std::system(
      (std::string(SWEEPSTAKED_PATH) + " probe " + arguments + " >/dev/null 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Returns the probe's error for a daemon that does not answer.
std::string Complaint(const std::string& arguments) {
  FILE* probe =
      popen((std::string(SWEEPSTAKED_PATH) + " probe " + arguments + " 2>&1").c_str(), "r");
  std::string said;
  for (int letter = std::fgetc(probe); letter != EOF; letter = std::fgetc(probe))
    said += static_cast<char>(letter);
  EXPECT_EQ(WEXITSTATUS(pclose(probe)), 1);
  return said;
}

TEST(ProbeTest, DistinguishesARunningDaemonFromNone) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  EXPECT_EQ(Probe("--listen " + daemon.address()), 0);
  EXPECT_EQ(Probe("--listen 127.0.0.1:0 --port-file " + (data.path() / "port").string()), 0);
  EXPECT_EQ(Probe("--listen 127.0.0.1:0"), 1) << "the port is unknown";
  EXPECT_EQ(Probe("--listen nowhere"), 2);
  daemon.Kill();
  EXPECT_EQ(Probe("--listen " + daemon.address()), 1);
}

class TlsProbeTest : public ::testing::Test {
 protected:
  TlsProbeTest() { authority_.Issue("DNS:sweepstake.example", server_); }
  std::vector<std::string> Flags(const TestAuthority* client_authority) const {
    std::vector<std::string> flags = {"--tls-cert", server_.cert, "--tls-key", server_.key};
    if (client_authority != nullptr)
      flags.insert(flags.end(), {"--tls-client-ca", client_authority->cert()});
    return flags;
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  TestAuthority authority_{folder_.path() / "ca.pem"};
  TestAuthority other_authority_{folder_.path() / "other-ca.pem"};
  CertificateFiles server_{folder_.path() / "server.pem", folder_.path() / "server-key.pem"};
};

TEST_F(TlsProbeTest, ADaemonWithTlsProbesItselfWithAnyCertificateName) {
  NotifySocket manager(folder_.path(), std::chrono::seconds(60));
  for (const TestAuthority* clients : {static_cast<const TestAuthority*>(nullptr),
                                       static_cast<const TestAuthority*>(&authority_)}) {
    const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags(clients));
    std::string first = manager.Receive();
    if (first == "READY=1") first = manager.Receive();
    EXPECT_EQ(first, "WATCHDOG=1");
    std::string flags;
    for (const std::string& flag : Flags(clients)) flags += flag + " ";
    EXPECT_EQ(Probe(flags + "--listen " + daemon.address()), 0);
    while (!manager.ReceiveNow().empty()) {
    }
  }
}

TEST_F(TlsProbeTest, BrokenFilesDoNotMakeTheServiceManagerEndADaemonThatServes) {
  NotifySocket manager(folder_.path(), std::chrono::seconds(12));
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags(nullptr));
  const auto receive_alive = [&] {
    std::string next = manager.Receive();
    while (next == "READY=1") next = manager.Receive();
    return next;
  };
  EXPECT_EQ(receive_alive(), "WATCHDOG=1");
  std::ofstream(server_.key) << "half of a key";
  EXPECT_EQ(receive_alive(), "WATCHDOG=1") << "possibly of a probe that began before";
  EXPECT_EQ(receive_alive(), "WATCHDOG=1");
}

TEST_F(TlsProbeTest, AFailedProbeExplainsPossibleCauses) {
  std::string tls;
  for (const std::string& flag : Flags(nullptr)) tls += flag + " ";
  std::string address;
  {
    const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags(&other_authority_));
    address = "--listen " + daemon.address();
    EXPECT_THAT(Complaint(tls + address), HasSubstr("as a client certificate"));
    EXPECT_THAT(Complaint(address), HasSubstr("the daemon may require TLS"));
    EXPECT_THAT(Complaint("--tls-cert nowhere.pem --tls-key nowhere.pem " + address),
                HasSubstr("cannot read nowhere.pem"));
  }
  EXPECT_THAT(Complaint(address), HasSubstr("is the daemon running there?"));
  const DaemonProcess plain(data_.path());
  EXPECT_THAT(Complaint(tls + "--listen " + plain.address()),
              HasSubstr("the daemon uses plain text"));
}

TEST_F(TlsProbeTest, AProbeReportsTheDaemonsExpiredCertificateIfClientsNeedOne) {
  authority_.Issue("DNS:sweepstake.example", server_, /*expires_in_s=*/-60);
  std::string tls;
  for (const std::string& flag : Flags(nullptr)) tls += flag + " ";
  for (const TestAuthority* clients : {static_cast<const TestAuthority*>(nullptr),
                                       static_cast<const TestAuthority*>(&authority_)}) {
    const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags(clients));
    const std::string probe = tls + "--listen " + daemon.address();
    if (clients == nullptr) {
      EXPECT_EQ(Probe(probe), 0) << "the daemon still serves; games report the expired certificate";
    } else {
      EXPECT_THAT(Complaint(probe), HasSubstr("must not have expired"));
    }
  }
}

TEST_F(TlsProbeTest, ADaemonThatCannotProbeItselfDoesNotStartUnderAWatchdog) {
  NotifySocket manager(folder_.path(), std::chrono::seconds(60));
  std::string command = std::string(SWEEPSTAKED_PATH) + " --listen 127.0.0.1:0 --data " +
                        (data_.path() / "data").string();
  for (const std::string& flag : Flags(&other_authority_)) command += " " + flag;
  const int status = std::system((command + " 2>/dev/null").c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_EQ(manager.ReceiveNow(), "") << "the daemon was never ready";
}

}  // namespace
}  // namespace sweepstake::test_support
