// Tests `sweepstake-lab load` with a real daemon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

TEST(LoadProgram, MeasuresADaemonAndPrintsItsFigures) {
  const test_support::TemporaryDirectory data;
  const test_support::DaemonProcess daemon(data.path());
  const std::string load =
      "load --project arcade --streams 50 --rate 4 --bail-out-share 0.2 "
      "--duration 2s --daemon " +
      daemon.address();
  const ProgramRun run = RunLab(load + " --json --server-pid " + std::to_string(daemon.pid()));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json figures = json::parse(run.out);
  EXPECT_EQ(figures["streams"], 50);
  EXPECT_EQ(figures["finished"], 50);
  EXPECT_EQ(figures["rejected"], 0);
  EXPECT_GT(figures["batches_per_s"], 0);
  EXPECT_EQ(figures["frames_per_s"], 60 * figures["batches_per_s"].get<double>());
  EXPECT_GE(figures["decision_latency_ms_p99"], figures["decision_latency_ms_p50"]);
  EXPECT_GE(figures["tick_lateness_ms_p99"], 0);
  EXPECT_GE(figures["server_cpu_s"], 0);
  EXPECT_FALSE(figures.contains("reconnect_s"));
  const json audit = json::parse(
      RunProgram("audit list --json --project arcade --daemon " + daemon.address()).out);
  EXPECT_EQ(audit["segments"].size(), 50U);
}

TEST(LoadProgram, GamesThatAreRefusedEndItWithThreeAndTheReason) {
  const test_support::TemporaryDirectory data;
  const test_support::DaemonProcess daemon(data.path(), "127.0.0.1:0", {"--max-sessions", "2"});
  const ProgramRun run = RunLab("load --streams 4 --duration 1s --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out, HasSubstr("finished"));
  // The last game may still find a free session if the machine is slow.
  EXPECT_THAT(run.err, ContainsRegex("[23] of 4 games finished; the last error: "));
  EXPECT_THAT(run.err, HasSubstr("(TOO_MANY_SESSIONS)"));
}

TEST(LoadProgram, BadUsageEndsWithTwoAndNobodyThereWithThree) {
  const ProgramRun none = RunLab("load --daemon 127.0.0.1:1 --streams 0");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("not in range 1 to 100000\n"));
  EXPECT_EQ(RunLab("load --daemon 127.0.0.1:1 --frames-per-batch 241").exit_code, 2);
  const ProgramRun run = RunLab("load --daemon 127.0.0.1:1 --streams 3");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("no daemon answered at 127.0.0.1:1"));
}

}  // namespace
}  // namespace sweepstake::cli
