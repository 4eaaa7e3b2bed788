// Tests of the commands that connect to a daemon, with tokens.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <string>
#include <vector>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using ::sweepstake::test_support::DaemonProcess;
using ::sweepstake::test_support::FileText;
using ::sweepstake::test_support::TemporaryDirectory;
using ::testing::HasSubstr;
using ::testing::Not;

// Sets an environment variable during the lifetime of the object.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

class TokenProgram : public ::testing::Test {
 protected:
  TokenProgram() : admin_(MakeToken("admin")), watch_(MakeToken("watch")) {}

  // Creates a token with the role and returns its file.
  std::string MakeToken(const std::string& role) const {
    const std::string file = Path(role + ".token");
    const ProgramRun run = RunDaemonProgram("token create " + role + " --role " + role + " --out " +
                                            file + " --data " + data_.path().string());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return file;
  }
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string Daemon() const { return " --daemon " + daemon_.address(); }
  static std::string Token(const std::string& file) {
    std::string token = FileText(file);
    token.pop_back();  // the line break
    return token;
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  std::string admin_;
  std::string watch_;
  DaemonProcess daemon_{data_.path()};
};

TEST_F(TokenProgram, EveryCommandThatConnectsToADaemonSendsItsToken) {
  for (const std::string& command : ConnectingCommands(folder_.path().string())) {
    const ProgramRun run = RunEither(command + Daemon() + " --token-file " + admin_);
    EXPECT_EQ(run.exit_code, 0) << command << '\n' << run.err;
  }
}

TEST_F(TokenProgram, EnvironmentVariablesCanHoldTheTokenOrNameItsFile) {
  const std::string command = "watch --once" + Daemon();
  {
    const Variable token("SWEEPSTAKE_CLIENT_TOKEN", Token(watch_));
    EXPECT_EQ(RunProgram(command).exit_code, 0);
  }
  const Variable file("SWEEPSTAKE_CLIENT_TOKEN_FILE", watch_);
  EXPECT_EQ(RunProgram(command).exit_code, 0);
  // The option has precedence over the variables.
  const Variable wrong("SWEEPSTAKE_CLIENT_TOKEN", "wrong");
  EXPECT_EQ(RunProgram(command + " --token-file " + watch_).exit_code, 0);
}

TEST_F(TokenProgram, AMissingOrWrongTokenGivesAdviceAndDoesNotRevealTheToken) {
  const std::string command = "priors list" + Daemon();
  const ProgramRun without = RunProgram(command);
  EXPECT_NE(without.exit_code, 0);
  EXPECT_THAT(without.err, HasSubstr("TOKEN_MISSING"));
  const Variable token("SWEEPSTAKE_CLIENT_TOKEN", Token(watch_) + "x");
  const ProgramRun wrong = RunProgram(command);
  EXPECT_NE(wrong.exit_code, 0);
  EXPECT_THAT(wrong.err, HasSubstr("TOKEN_REFUSED"));
  EXPECT_THAT(wrong.err, Not(HasSubstr(Token(watch_))));
  EXPECT_EQ(without.out + wrong.out, "");
}

TEST_F(TokenProgram, ATokenOfAnotherRoleIsRefused) {
  const std::string priors = Path("priors.json") + Daemon() + " --token-file ";
  EXPECT_EQ(RunProgram("priors export --out " + priors + watch_).exit_code, 0);
  const ProgramRun import = RunProgram("priors import --in " + priors + watch_);
  EXPECT_NE(import.exit_code, 0);
  EXPECT_THAT(import.err, HasSubstr("NOT_ALLOWED"));
  const ProgramRun play = RunProgram("run --scene suite-b --objects 100 --duration 10m" + Daemon() +
                                     " --token-file " + watch_);
  EXPECT_EQ(play.exit_code, 2);
  EXPECT_THAT(play.err, HasSubstr("NOT_ALLOWED"));
}

}  // namespace
}  // namespace sweepstake::cli
