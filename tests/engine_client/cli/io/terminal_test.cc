#include "engine_client/cli/io/terminal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

class TerminalTest : public testing::Test {
 protected:
  Terminal Tty(size_t columns) {
    return {.out = out_, .err = err_, .err_is_tty = true, .err_columns = columns};
  }
  Terminal File() { return {.out = out_, .err = err_}; }

  std::ostringstream out_;
  std::ostringstream err_;
};

TEST_F(TerminalTest, FailPrintsOneLineAndChoosesTheExitCode) {
  const struct {
    StatusCode code;
    int exit_code;
  } cases[] = {{StatusCode::kUnavailable, kUnreachable},
               {StatusCode::kInternal, kCheckFailed},
               {StatusCode::kInvalidArgument, kBadUsage},
               {StatusCode::kNotFound, kBadUsage},
               {StatusCode::kResourceExhausted, kBadUsage}};
  for (const auto& [code, exit_code] : cases) {
    err_.str("");
    Terminal terminal = File();
    EXPECT_EQ(Fail(terminal, Status(code, "no luck")), exit_code);
    EXPECT_EQ(err_.str(), "sweepstake: no luck\n");
  }
  EXPECT_EQ(out_.str(), "");
}

TEST_F(TerminalTest, FailAnswerDistinguishesRefusalBadUsageAndNoDaemon) {
  const struct {
    StatusCode code;
    int exit_code;
  } cases[] = {{StatusCode::kUnavailable, kUnreachable},
               {StatusCode::kResourceExhausted, kUnreachable},
               {StatusCode::kInvalidArgument, kBadUsage},
               {StatusCode::kNotFound, kCheckFailed},
               {StatusCode::kFailedPrecondition, kCheckFailed},
               {StatusCode::kInternal, kCheckFailed}};
  for (const auto& [code, exit_code] : cases) {
    Terminal terminal = File();
    EXPECT_EQ(FailAnswer(terminal, Status(code, "no luck")), exit_code);
  }
}

TEST(CutToColumns, CutsBetweenCharacters) {
  EXPECT_EQ(CutToColumns("a · b", 9), "a · b");
  EXPECT_EQ(CutToColumns("a · b", 3), "a ·");
  EXPECT_EQ(CutToColumns("a · b", 2), "a ");
  EXPECT_EQ(CutToColumns("a · b", 0), "");
}

TEST_F(TerminalTest, ProgressDrawsABarAtOnceAndClearsItAtTheEnd) {
  Terminal terminal = Tty(80);
  {
    Progress progress(terminal, "check", 10);
    EXPECT_TRUE(progress.due());
    progress.Show(3, "suite-b");
    EXPECT_THAT(err_.str(), HasSubstr("check [#########....................."));
    EXPECT_THAT(err_.str(), HasSubstr("] 30 % suite-b"));
    EXPECT_FALSE(progress.due());
  }
  EXPECT_THAT(err_.str(), testing::EndsWith("\r\x1b[K"));
  EXPECT_EQ(out_.str(), "");
}

TEST_F(TerminalTest, ProgressDrawsNothingBeforeItIsDueAgain) {
  Terminal terminal = Tty(80);
  Progress progress(terminal, "check", 10);
  progress.Show(1);
  const std::string drawn = err_.str();
  progress.Show(2);
  EXPECT_EQ(err_.str(), drawn);
}

TEST_F(TerminalTest, ProgressBeyondItsTotalIsFull) {
  Terminal terminal = Tty(80);
  Progress progress(terminal, "check", 10);
  progress.Show(25);
  EXPECT_THAT(err_.str(), HasSubstr("[##############################] 100 %"));
}

TEST_F(TerminalTest, ProgressLeavesOneColumnOfTheTerminalFree) {
  Terminal terminal = Tty(20);
  Progress progress(terminal, "a label", 0);
  progress.Show(0, "that is longer than the line");
  EXPECT_EQ(err_.str(), "a label that is lon");
}

TEST_F(TerminalTest, ProgressWithoutATotalHasNoBar) {
  Terminal terminal = Tty(80);
  Progress progress(terminal, "run", 0);
  progress.Show(5, "SAP");
  EXPECT_EQ(err_.str(), "run SAP");
}

TEST_F(TerminalTest, ALineAppearsAboveTheBar) {
  Terminal terminal = Tty(80);
  Progress progress(terminal, "run", 0);
  progress.Show(1, "bar");
  err_.str("");
  progress.Line("a switch");
  EXPECT_EQ(err_.str(), "\r\x1b[Ka switch\n");
  progress.ClearBar();
  EXPECT_EQ(err_.str(), "\r\x1b[Ka switch\n") << "the bar is cleared only once";
}

TEST_F(TerminalTest, ProgressInAFileHasNoControlCharacters) {
  Terminal terminal = File();
  {
    Progress progress(terminal, "check", 10);
    EXPECT_FALSE(progress.due()) << "the first line comes after some seconds";
    progress.Show(3);
    progress.Line("a line");
  }
  EXPECT_EQ(err_.str(), "a line\n");
}

}  // namespace
}  // namespace sweepstake::cli
