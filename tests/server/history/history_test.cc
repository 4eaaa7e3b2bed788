// Tests the history's thread: damaged files, limits of its queue, and its end.
#include "server/history/history.h"

#include <gtest/gtest.h>

#include <fstream>
#include <future>

#include "server/sessions/common/unix_time.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::history {
namespace {

HistoryBatch Batch(size_t report_count) {
  HistoryBatch batch;
  SessionReport report = {
      .scene = {"game", "harbour", "", 1}, .build = "12", .session = "a", .arms = {"SAP"}};
  report.use.unix_start_ms = priors::UnixNowMs() - 1'000;
  report.use.unix_end_ms = report.use.unix_start_ms + 500;
  report.use.active_frame_counts = {1};
  report.use.measured = {.frame_count = 1, .ran_us = 5, .arm_us = {6}, .known_frame_counts = {1}};
  batch.reports.assign(report_count, report);
  return batch;
}

class HistoryTest : public ::testing::Test {
 protected:
  std::unique_ptr<History> Open() {
    auto history = History::Open(path_, {}, [this](const std::string& problem) {
      const std::lock_guard lock(mutex_);
      problems_ += problem;
    });
    EXPECT_TRUE(history.ok()) << history.status();
    return *std::move(history);
  }
  static uint64_t FrameCount(History& history) {
    std::promise<uint64_t> count;
    EXPECT_TRUE(history.Read({.max_points = 1}, [&](const absl::StatusOr<HistoryPage>& page) {
      EXPECT_TRUE(page.ok()) << page.status();
      count.set_value(page->series.empty() ? 0 : page->series[0].points(0).frame_count());
    }));
    return count.get_future().get();
  }
  std::string problems() {
    const std::lock_guard lock(mutex_);
    return problems_;
  }

  const test_support::TemporaryDirectory directory_;
  const std::filesystem::path path_ = directory_.path() / "history.db";
  std::mutex mutex_;
  std::string problems_;  // guarded by mutex_
};

TEST_F(HistoryTest, AReadSeesTheWritesBeforeIt) {
  const auto history = Open();
  history->Write(Batch(3));
  EXPECT_EQ(FrameCount(*history), 3U);
  EXPECT_EQ(problems(), "");
}

TEST_F(HistoryTest, AFileThatIsNoHistoryIsSetAside) {
  std::ofstream(path_) << std::string(10'000, 'x');
  const auto history = Open();
  EXPECT_NE(problems().find("history.db.damaged"), std::string::npos) << problems();
  history->Write(Batch(1));
  EXPECT_EQ(FrameCount(*history), 1U);
}

TEST_F(HistoryTest, ADamagedPageIsFoundAfterTheStart) {
  {
    const auto history = Open();
    for (int i = 0; i < 200; ++i) {
      HistoryBatch batch = Batch(1);
      batch.reports[0].scene.scene = std::to_string(i);
      history->Write(std::move(batch));
    }
  }
  {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    for (int page = 20; page < 48; ++page) {
      file.seekp(page * 4096);
      file << std::string(4096, 'x');
    }
  }
  const auto history = Open();
  history->Write(Batch(1));
  EXPECT_EQ(FrameCount(*history), 1U);
  EXPECT_NE(problems().find("history.db.damaged"), std::string::npos) << problems();
}

TEST_F(HistoryTest, ARemovedFileIsMadeAgain) {
  const auto history = Open();
  history->Write(Batch(1));
  EXPECT_EQ(FrameCount(*history), 1U);
  std::filesystem::remove(path_);
  history->Write(Batch(1));  // finds out, and is lost
  history->Write(Batch(1));
  EXPECT_EQ(FrameCount(*history), 1U);
}

TEST_F(HistoryTest, TooManyReportsAreRefused) {
  const auto history = Open();
  history->Write(Batch(History::kMaxQueuedReports + 1));
  EXPECT_NE(problems().find("lacks some points"), std::string::npos);
  EXPECT_EQ(FrameCount(*history), 0U);
}

TEST_F(HistoryTest, AClosedHistoryRefusesReads) {
  const auto history = Open();
  history->Write(Batch(2));
  history->Close();
  EXPECT_FALSE(history->Read({}, [](const absl::StatusOr<HistoryPage>& /*page*/) { FAIL(); }));
  EXPECT_EQ(FrameCount(*Open()), 2U) << "queued writes are written";
}

}  // namespace
}  // namespace sweepstake::history
