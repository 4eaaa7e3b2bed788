// Tests of the commands that connect to a daemon, with TLS.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using ::sweepstake::test_support::CertificateFiles;
using ::sweepstake::test_support::DaemonProcess;
using ::sweepstake::test_support::TemporaryDirectory;
using ::sweepstake::test_support::TestAuthority;
using ::testing::HasSubstr;
using ::testing::Not;

// The daemon requires client certificates. Its own certificate is for a name that no machine has.
class TlsProgram : public ::testing::Test {
 protected:
  TlsProgram() {
    authority_.Issue("DNS:sweepstake.example", server_);
    authority_.Issue("DNS:game", client_);
    daemon_ = std::make_unique<DaemonProcess>(
        data_.path(), "127.0.0.1:0",
        std::vector<std::string>{"--tls-cert", server_.cert, "--tls-key", server_.key,
                                 "--tls-client-ca", authority_.cert()});
  }

  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string Daemon() const { return " --daemon " + daemon_->address(); }
  std::string Trusting() const {
    return Daemon() + " --tls-server-name sweepstake.example --tls-ca " +
           authority_.cert().string();
  }
  std::string WithTls() const {
    return Trusting() + " --tls-cert " + client_.cert.string() + " --tls-key " +
           client_.key.string();
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  TestAuthority authority_{Path("ca.pem")};
  CertificateFiles server_{Path("server.pem"), Path("server-key.pem")};
  CertificateFiles client_{Path("client.pem"), Path("client-key.pem")};
  std::unique_ptr<DaemonProcess> daemon_;
};

TEST_F(TlsProgram, EveryCommandThatConnectsToADaemonSupportsTls) {
  for (const std::string& command : ConnectingCommands(folder_.path().string())) {
    const ProgramRun run = RunEither(command + WithTls());
    EXPECT_EQ(run.exit_code, 0) << command << '\n' << run.err;
  }
}

TEST_F(TlsProgram, EnvironmentVariablesCanNameTheFiles) {
  setenv("SWEEPSTAKE_CLIENT_TLS_CA", authority_.cert().c_str(), 1);
  setenv("SWEEPSTAKE_CLIENT_TLS_CERT", client_.cert.c_str(), 1);
  setenv("SWEEPSTAKE_CLIENT_TLS_KEY", client_.key.c_str(), 1);
  setenv("SWEEPSTAKE_CLIENT_TLS_SERVER_NAME", "sweepstake.example", 1);
  const ProgramRun run = RunProgram("watch --once" + Daemon());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  // `sweepstaked` ignores these variables of `sweepstake`.
  EXPECT_EQ(RunDaemonProgram("--print-config").exit_code, 0);
  for (const char* name : {"CA", "CERT", "KEY", "SERVER_NAME"}) {
    unsetenv((std::string("SWEEPSTAKE_CLIENT_TLS_") + name).c_str());
  }
}

TEST_F(TlsProgram, ErrorsSayWhatToDo) {
  const struct {
    std::string options;
    int exit_code;
    const char* said;
  } cases[] = {
      {Daemon(), 3,
       "may require TLS: give the certificate of the authority that signed its own (--tls-ca)"},
      {Daemon() + " --tls", 3, "give the certificate of the authority that signed it (--tls-ca)"},
      {Daemon() + " --tls-ca " + authority_.cert().string(), 3,
       "give its name (--tls-server-name)"},
      {Trusting(), 3,
       "may require a client certificate: give one that its authority has signed (--tls-cert and "
       "--tls-key); otherwise its own TLS files may be broken: see its log or /readyz"},
      {Daemon() + " --tls-ca nowhere.pem", 2, "cannot read nowhere.pem"},
      {Daemon() + " --tls-cert " + client_.cert.string(), 2,
       "--tls-cert and --tls-key must be set together or not at all"},
      {Daemon() + " --tls-server-name 'a b'", 2, "--tls-server-name must be a host name"},
  };
  for (const auto& [options, exit_code, said] : cases) {
    for (const std::string command :
         {"watch --once", "load --streams 1 --duration 100ms", "priors list",
          "run --scene suite-b --objects 10 --duration 2s"}) {
      const ProgramRun run = RunEither(command + options);
      EXPECT_EQ(run.exit_code, exit_code) << command << options << '\n' << run.err;
      EXPECT_THAT(run.err, HasSubstr(said)) << command << options;
      EXPECT_THAT(run.err, Not(HasSubstr(".cc:"))) << "log lines of gRPC: " << command << options;
    }
  }
}

TEST(DaemonTlsProgram, AnUnusableFileEndsTheStartAndIsNamed) {
  const TemporaryDirectory folder;
  const TestAuthority authority(folder.path() / "ca.pem");
  const CertificateFiles one{folder.path() / "one.pem", folder.path() / "one-key.pem"};
  const CertificateFiles two{folder.path() / "two.pem", folder.path() / "two-key.pem"};
  authority.Issue("IP:127.0.0.1", one);
  authority.Issue("IP:127.0.0.1", two);
  const std::string start = "--data " + (folder.path() / "data").string();
  const std::string cert = " --listen 127.0.0.1:0 --tls-cert " + one.cert.string();
  const struct {
    std::string options;
    int exit_code;
    const char* said;
  } cases[] = {
      {cert, 2, "tls_cert and tls_key go together"},
      {" --tls-client-ca " + authority.cert().string(), 2, "tls_client_ca needs TLS"},
      {cert + " --tls-key nowhere.pem", 3, "cannot read nowhere.pem"},
      {cert + " --tls-key " + two.key.string(), 3, "name the key of this certificate"},
      {cert + " --tls-key " + one.key.string() + " --tls-client-ca " + two.key.string(), 3,
       "contains no complete certificate"},
      {" --listen 0.0.0.0:0", 2, "set --tls-cert and --tls-key"},
  };
  for (const auto& [options, exit_code, said] : cases) {
    const ProgramRun run = RunDaemonProgram(start + options);
    EXPECT_EQ(run.exit_code, exit_code) << options << '\n' << run.err;
    EXPECT_THAT(run.err, HasSubstr(said)) << options;
  }
}

}  // namespace
}  // namespace sweepstake::cli
