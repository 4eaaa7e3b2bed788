// Tests the HTTP pages for operators of a running daemon, and that Prometheus can read them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "server/storage/sqlite_prior_store.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/child_process.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::test_support {
namespace {

using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Lt;

DaemonProcess StartWithHttp(const TemporaryDirectory& data,
                            const std::vector<std::string>& more_arguments = {}) {
  std::vector<std::string> arguments = {"--http", "127.0.0.1:0"};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  return DaemonProcess(data.path(), "127.0.0.1:0", arguments);
}

// Returns the value of a series in Prometheus' text format, or -1.
double ValueOf(const std::string& text, const std::string& series) {
  const size_t line = ("\n" + text).find("\n" + series + " ");
  return line == std::string::npos ? -1 : std::stod(text.substr(line + series.size() + 1));
}

double Metric(const DaemonProcess& daemon, const std::string& series) {
  return ValueOf(Get(daemon.http_port(), "/metrics").body, series);
}

template <typename Condition>
bool Eventually(Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

TEST(MetricsTest, MetricsChangeWhenAGameStreams) {
  const TemporaryDirectory data;
  DaemonProcess daemon = StartWithHttp(data);
  const std::string before = Get(daemon.http_port(), "/metrics").body;
  EXPECT_EQ(ValueOf(before, "sweepstake_decisions_total"), 0);
  EXPECT_EQ(ValueOf(before, "sweepstake_open_streams"), 0);

  ScriptedGame game(daemon.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) {
    return stats.acknowledged_sequence >= 40;
  })) << game.stats().last_error;
  const std::string text = Get(daemon.http_port(), "/metrics").body;
  EXPECT_EQ(ValueOf(text, "sweepstake_open_streams"), 1);
  EXPECT_EQ(ValueOf(text, "sweepstake_welcomed_streams_total"), 1);
  for (const std::string series :
       {"sweepstake_decisions_total", "sweepstake_applied_messages_total",
        "sweepstake_accepted_frames_total", "sweepstake_stored_commits_total",
        "sweepstake_store_commit_duration_seconds_count",
        "sweepstake_store_fsync_duration_seconds_count", "sweepstake_store_wal_size_bytes",
        "sweepstake_decision_loop_lateness_seconds_count"}) {
    EXPECT_THAT(ValueOf(text, series), Gt(std::max(0.0, ValueOf(before, series)))) << series;
  }
  EXPECT_THAT(std::count(text.begin(), text.end(), '\n'), Lt(5'000));

  game.Stop();
  EXPECT_TRUE(Eventually([&] { return Metric(daemon, "sweepstake_open_streams") == 0; }));
  EXPECT_EQ(Metric(daemon, "sweepstake_ended_sessions_total"), 1);
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST(MetricsTest, TheDaemonRaisesItsLimitOfOpenFiles) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit low{.rlim_cur = 256, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &low);
  const TemporaryDirectory data;
  const DaemonProcess daemon = StartWithHttp(data);
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_THAT(Metric(daemon, "process_max_fds"), Gt(256));
  EXPECT_THAT(Metric(daemon, "process_open_fds"), Gt(0));
}

TEST(MetricsTest, ADaemonIsNotReadyWhileItsStoreCannotBeWritten) {
  const TemporaryDirectory data;
  DaemonProcess daemon = StartWithHttp(data);
  ScriptedGame game(daemon.address(), FastOptions());
  EXPECT_EQ(Get(daemon.http_port(), "/readyz").status, 200);

  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((data.path() / "priors.db").c_str(), &other), SQLITE_OK);
  sqlite3_busy_timeout(other, 60'000);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  HttpAnswer ready;
  EXPECT_TRUE(Eventually([&] {
    game.RunFrames(100);
    return (ready = Get(daemon.http_port(), "/readyz")).status == 503;
  }));
  EXPECT_THAT(ready.body, HasSubstr("[-]store failed"));
  EXPECT_EQ(Metric(daemon, "sweepstake_store_healthy"), 0);
  EXPECT_EQ(Get(daemon.http_port(), "/livez").status, 200) << "a restart would not help";

  sqlite3_close(other);
  EXPECT_TRUE(Eventually([&] {
    game.RunFrames(100);
    return Get(daemon.http_port(), "/readyz").status == 200;
  }));
}

int RunShell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Returns the names of all metrics in the daemon's sources.
std::set<std::string> NamesInSources() {
  static const std::regex kName("\"((sweepstake|process)_[a-z0-9_]+)\"");
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(SERVER_SOURCES)) {
    if (entry.path().extension() != ".cc") continue;
    const std::string text = FileText(entry.path());
    for (std::sregex_iterator name(text.begin(), text.end(), kName), end; name != end; ++name)
      names.insert((*name)[1]);
  }
  return names;
}

// Returns the names of the metrics on a page.
std::set<std::string> NamesOn(const std::string& page) {
  static const std::regex kType("# TYPE (\\w+) ");
  std::set<std::string> names;
  for (std::sregex_iterator name(page.begin(), page.end(), kType), end; name != end; ++name)
    names.insert((*name)[1]);
  return names;
}

TEST(MetricsTest, PromtoolHasNoComplaintAboutAnyMetric) {
  const TemporaryDirectory data;
  const TemporaryDirectory folder;
  // Some metrics exist only with TLS, so the daemon needs a certificate.
  const TestAuthority authority(folder.path() / "ca.pem");
  const CertificateFiles server{folder.path() / "server.pem", folder.path() / "server-key.pem"};
  authority.Issue("IP:127.0.0.1", server);
  const DaemonProcess daemon = StartWithHttp(
      data, {"--tls-cert", server.cert, "--tls-key", server.key, "--metrics-scenes", "10"});
  SessionOptions options = FastOptions();
  options.tls.emplace().ca_file = authority.cert();
  ScriptedGame game(daemon.address(), options);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.command_count > 0; }));
  // With the policy `paper`, the expected loss is not known in seconds.
  options.policy = "adaptive";
  options.scene = "adaptive";
  ScriptedGame adaptive(daemon.address(), options);
  const std::string page = folder.path() / "metrics";
  const std::string said = folder.path() / "said";
  std::string text;
  // The figures of scenes follow every five seconds.
  EXPECT_TRUE(Eventually([&] {
    adaptive.RunFrames(10);
    text = Get(daemon.http_port(), "/metrics").body;
    return NamesOn(text) == NamesInSources();
  }));
  EXPECT_EQ(NamesOn(text), NamesInSources()) << "the test must check every metric";
  std::ofstream(page) << text;
  EXPECT_EQ(RunShell("promtool check metrics <'" + page + "' >'" + said + "' 2>&1"), 0);
  EXPECT_EQ(FileText(said), "");
}

// A real Prometheus, which the destructor ends.
class Prometheus {
 public:
  Prometheus(const std::filesystem::path& folder, int target_port)
      : folder_(folder), process_(CommandLine(target_port), folder / "said") {}

  std::string log() const { return process_.log(); }
  // Returns all samples of a series that Prometheus has stored, as text.
  std::string Samples(const std::string& series) const {
    const std::string samples = folder_ / "samples";
    RunShell("promtool tsdb dump --match='" + series + "' '" + database() + "' >'" + samples +
             "' 2>/dev/null");
    return FileText(samples);
  }

 private:
  std::string database() const { return folder_ / "tsdb"; }
  std::vector<std::string> CommandLine(int target_port) const {
    const std::filesystem::path config = folder_ / "prometheus.yml";
    std::ofstream(config) << "scrape_configs:\n- job_name: sweepstake\n  scrape_interval: 1s\n"
                          << "  static_configs: [{targets: ['127.0.0.1:" << target_port << "']}]\n";
    return {"prometheus", "--config.file=" + config.string(), "--storage.tsdb.path=" + database(),
            "--web.listen-address=127.0.0.1:0"};
  }

  std::filesystem::path folder_;
  ChildProcess process_;
};

TEST(MetricsTest, ARealPrometheusScrapesTheMetrics) {
  const TemporaryDirectory data;
  const TemporaryDirectory folder;
  const DaemonProcess daemon = StartWithHttp(data);
  const Prometheus prometheus(folder.path(), daemon.http_port());
  std::string samples;
  EXPECT_TRUE(Eventually([&] {
    samples = prometheus.Samples("sweepstake_build_info");
    return !samples.empty();
  })) << prometheus.log();
  EXPECT_THAT(samples, HasSubstr("version="));
  EXPECT_THAT(prometheus.Samples("up"), HasSubstr("} 1 "));
  EXPECT_THAT(prometheus.Samples("sweepstake_store_healthy"), HasSubstr("} 1 "));
}

}  // namespace
}  // namespace sweepstake::test_support
