// Tests the history's file: resolutions, periods, pages, limits and damage.
#include "server/history/history_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "tests/support/temporary_directory.h"

namespace sweepstake::history {
namespace {

constexpr int64_t kNowS = 1'800'000'000;  // a multiple of an hour
constexpr int64_t kStepS = kResolutions[0].step_s;

SeriesKey Scene(const std::string& scene, const std::string& project = "game") {
  return {.kind = v1::HISTORY_KIND_SCENE, .scene = {project, scene, "", 1}};
}

v1::HistoryPoint Point(int64_t start_s, uint64_t frames = 1) {
  v1::HistoryPoint point;
  point.set_unix_ms(start_s * 1000);
  point.set_end_unix_ms((start_s + kStepS) * 1000);
  point.set_frame_count(frames);
  return point;
}

class HistoryFileTest : public ::testing::Test {
 protected:
  void SetUp() override { Open(); }
  void Open() {
    file_.reset();
    auto file = HistoryFile::Open(path_);
    ASSERT_TRUE(file.ok()) << file.status();
    file_ = *std::move(file);
  }
  void Add(const std::vector<HistoryEntry>& entries, int64_t now_s = kNowS) {
    steady_ns_ += 1'000'000'000'000;
    const absl::Status status = file_->Add(entries, limits_, now_s, steady_ns_);
    ASSERT_TRUE(status.ok()) << status;
  }
  HistoryPage Read(HistoryQuery query, int64_t now_s = kNowS) {
    const auto page = file_->Read(query, now_s);
    EXPECT_TRUE(page.ok()) << page.status();
    return page.value_or(HistoryPage());
  }
  v1::HistorySeries ReadOne(const HistoryQuery& query, int64_t now_s = kNowS) {
    const HistoryPage page = Read(query, now_s);
    EXPECT_EQ(page.series.size(), 1U);
    return page.series.empty() ? v1::HistorySeries() : page.series[0];
  }

  const test_support::TemporaryDirectory directory_;
  const std::filesystem::path path_ = directory_.path() / "history.db";
  HistoryLimits limits_;
  int64_t steady_ns_ = 0;
  std::unique_ptr<HistoryFile> file_;
};

TEST_F(HistoryFileTest, ReportsOfOnePeriodAreOnePoint) {
  Add({{Scene("harbour"), Point(kNowS - 30, 5)}});
  Add({{Scene("harbour"), Point(kNowS - 30, 7)}, {Scene("harbour"), Point(kNowS - 15, 1)}});
  const v1::HistorySeries series = ReadOne({.from_ms = (kNowS - 900) * 1000});
  EXPECT_EQ(series.project(), "game");
  EXPECT_EQ(series.scene(), "harbour");
  ASSERT_EQ(series.points_size(), 2);
  EXPECT_EQ(series.points(0).frame_count(), 12U);
  EXPECT_EQ(series.points(0).unix_ms(), (kNowS - 30) * 1000);
  EXPECT_EQ(series.points(1).frame_count(), 1U);
}

TEST_F(HistoryFileTest, AQueryMaySelectOneClassOfMachinesAndVersionOfTheReward) {
  SeriesKey other_class = Scene("harbour");
  other_class.scene.machine_class = "phone";
  SeriesKey other_version = Scene("harbour");
  other_version.scene.reward_version = 7;
  Add({{Scene("harbour"), Point(kNowS - 30, 1)},
       {other_class, Point(kNowS - 30, 2)},
       {other_version, Point(kNowS - 30, 3)}});
  EXPECT_EQ(Read({.max_points = 1}).series.size(), 3U);
  const auto frames = [&](uint32_t reward_version, const std::string& machine_class) {
    return ReadOne(
               {.reward_version = reward_version, .machine_class = machine_class, .max_points = 1})
        .points(0)
        .frame_count();
  };
  const priors::SceneKey key = Scene("harbour").scene;
  EXPECT_EQ(frames(key.reward_version, key.machine_class), 1U);
  EXPECT_EQ(frames(key.reward_version, "phone"), 2U);
  EXPECT_EQ(frames(7, key.machine_class), 3U);
}

TEST_F(HistoryFileTest, ARestartContinuesThePoints) {
  Add({{Scene("harbour"), Point(kNowS - 30, 5)}});
  Open();
  Add({{Scene("harbour"), Point(kNowS - 30, 7)}});
  EXPECT_EQ(ReadOne({.from_ms = (kNowS - 900) * 1000}).points(0).frame_count(), 12U);
}

TEST_F(HistoryFileTest, TheResolutionFitsThePeriod) {
  for (int64_t start_s = kNowS - 3 * 3600; start_s < kNowS; start_s += kStepS)
    Add({{Scene("harbour"), Point(start_s)}});
  const auto count = [&](int64_t period_s, uint32_t max_points) {
    return ReadOne({.from_ms = (kNowS - period_s) * 1000, .max_points = max_points}).points_size();
  };
  EXPECT_EQ(count(900, 300), 60) << "points of 15 s";
  EXPECT_EQ(count(900, 30), 30) << "two points of 15 s each";
  EXPECT_EQ(count(3 * 3600, 300), 36) << "points of 5 minutes, because those of 15 s are removed";
  EXPECT_EQ(count(20 * 86'400, 480), 3) << "points of an hour";
}

TEST_F(HistoryFileTest, SumsOverAPeriodAreExact) {
  for (int64_t start_s = kNowS - 3600; start_s < kNowS; start_s += kStepS)
    Add({{Scene("harbour"), Point(start_s)}});
  const v1::HistorySeries hour = ReadOne({.from_ms = (kNowS - 3600) * 1000, .max_points = 1});
  ASSERT_EQ(hour.points_size(), 1);
  EXPECT_EQ(hour.points(0).frame_count(), 240U);
  const v1::HistorySeries part =
      ReadOne({.from_ms = (kNowS - 900) * 1000, .until_ms = (kNowS - 300) * 1000, .max_points = 1});
  EXPECT_EQ(part.points(0).frame_count(), 40U);
}

TEST_F(HistoryFileTest, TheWholeLifeOutlastsItsPoints) {
  const int64_t later_s = kNowS + 80 * 86'400;
  Add({{Scene("harbour"), Point(kNowS, 5)}});
  Add({{Scene("harbour"), Point(later_s, 2)}}, later_s);
  const v1::HistorySeries life = ReadOne({.max_points = 1}, later_s);
  ASSERT_EQ(life.points_size(), 1);
  EXPECT_EQ(life.points(0).frame_count(), 7U);
  EXPECT_EQ(life.points(0).unix_ms(), kNowS * 1000);
}

TEST_F(HistoryFileTest, OldPointsAndSeriesAreRemoved) {
  Add({{Scene("old"), Point(kNowS - 15)}});
  const int64_t later_s = kNowS + 91 * 86'400;
  for (int i = 0; i < 400; ++i) Add({{Scene("new"), Point(later_s - 15)}}, later_s);
  const HistoryPage page = Read({.from_ms = 1}, later_s);
  ASSERT_EQ(page.series.size(), 1U);
  EXPECT_EQ(page.series[0].scene(), "new");
  EXPECT_EQ(Read({.max_points = 1}, later_s).series.size(), 1U);
}

TEST_F(HistoryFileTest, AClockFarAheadRemovesNothingAtOnce) {
  Add({{Scene("harbour"), Point(kNowS - 15)}});
  const absl::Status status = file_->Add({{Scene("other"), Point(kNowS - 15)}}, limits_,
                                         kNowS + 3650 * 86'400, steady_ns_ + 1);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(Read({.from_ms = (kNowS - 900) * 1000}).series.size(), 2U);
}

TEST_F(HistoryFileTest, TheFileStaysBelowItsLimit) {
  limits_.bytes = 1 << 20;
  v1::HistoryPoint point = Point(kNowS);
  point.mutable_activity()->set_session_id(std::string(2'000, 'x'));
  for (int i = 0; i < 200; ++i) {
    point.set_unix_ms((kNowS - (200 - i) * kStepS) * 1000);
    point.set_end_unix_ms(point.unix_ms() + kStepS * 1000);
    std::vector<HistoryEntry> entries;
    for (int scene = 0; scene < 10; ++scene)
      entries.emplace_back(Scene("scene " + std::to_string(scene)), point);
    Add(entries, kNowS - (200 - i) * kStepS);
  }
  Add({});
  EXPECT_LE(std::filesystem::file_size(path_), (1 << 20) + (1 << 18));
  const v1::HistorySeries series =
      ReadOne({.filter = {"game", "scene 3"}, .from_ms = (kNowS - 900) * 1000});
  ASSERT_GT(series.points_size(), 5) << "the latest points are kept";
  EXPECT_EQ(series.points().rbegin()->unix_ms(), (kNowS - kStepS) * 1000);
  const HistoryPage lives = Read({.max_points = 1});
  ASSERT_EQ(lives.series.size(), 10U) << "series that are still played stay";
  EXPECT_EQ(lives.series[0].points(0).frame_count(), 200U);
}

TEST_F(HistoryFileTest, ManyShortPointsDoNotDisplaceLongHistory) {
  limits_.bytes = 1 << 20;
  for (int hour = 300; hour > 0; --hour) {
    const int64_t start_s = kNowS - hour * 3600;
    Add({{Scene("old"), Point(start_s)}}, start_s + 60);
  }
  const auto hours = [&] {
    const v1::HistorySeries series = ReadOne(
        {.filter = {"game", "old"}, .from_ms = (kNowS - 301 * 3600) * 1000, .max_points = 1'000});
    return series.points_size();
  };
  EXPECT_EQ(hours(), 300);
  v1::HistoryPoint point = Point(kNowS - 30);
  point.mutable_activity()->set_session_id(std::string(1'000, 'x'));
  for (int i = 0; i < 40; ++i) {
    std::vector<HistoryEntry> entries;
    for (int j = 0; j < 50; ++j)
      entries.emplace_back(Scene(std::to_string(i) + "." + std::to_string(j), "other"), point);
    Add(entries);
  }
  EXPECT_EQ(hours(), 300) << "a project with more points loses its own first";
}

TEST_F(HistoryFileTest, PointsOfAWrongClockAreRemoved) {
  const int64_t future_s = kNowS + 3650 * 86'400;
  Add({{Scene("harbour"), Point(future_s)}}, future_s);
  Open();
  for (int i = 0; i < 400; ++i) Add({{Scene("harbour"), Point(kNowS - 15)}});
  EXPECT_EQ(ReadOne({.from_ms = (kNowS - 900) * 1000}).points_size(), 1);
  HistoryQuery query = {.from_ms = (kNowS - 900) * 1000, .until_ms = (future_s + 900) * 1000};
  EXPECT_EQ(ReadOne(query).points_size(), 1) << "the point of the future is removed";
}

TEST_F(HistoryFileTest, ARemovedFileIsNotFound) {
  std::filesystem::remove(path_);
  EXPECT_TRUE(absl::IsNotFound(file_->Add({}, limits_, kNowS, 1)));
  EXPECT_TRUE(absl::IsNotFound(file_->Read({}, kNowS).status()));
}

TEST_F(HistoryFileTest, AnotherProgramsDatabaseIsDataLoss) {
  file_.reset();
  std::filesystem::remove(path_);
  {
    auto database =
        storage::SqliteDatabase::Open(path_.string(), storage::SqliteDatabase::OpenMode::kCreate);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database->Execute("CREATE TABLE series (x); PRAGMA user_version = 1").ok());
  }
  EXPECT_TRUE(absl::IsDataLoss(HistoryFile::Open(path_).status()));
}

TEST_F(HistoryFileTest, PagesHaveEverySeriesOnce) {
  std::vector<HistoryEntry> entries;
  for (int i = 0; i < 450; ++i) entries.emplace_back(Scene(std::to_string(i)), Point(kNowS - 15));
  Add(entries);
  HistoryQuery query = {.from_ms = (kNowS - 900) * 1000};
  std::set<std::string> scenes;
  size_t count = 0;
  do {
    const HistoryPage page = Read(query);
    for (const v1::HistorySeries& series : page.series) scenes.insert(series.scene());
    count += page.series.size();
    query.after = page.next;
  } while (query.after);
  EXPECT_EQ(scenes.size(), 450U);
  EXPECT_EQ(count, 450U);
}

TEST_F(HistoryFileTest, ALargeSeriesEndsItsPage) {
  v1::HistoryPoint point = Point(kNowS - 15);
  point.mutable_activity()->set_session_id(std::string(HistoryFile::kMaxPageBytes - 1'000, 'x'));
  Add({{Scene("a"), point}, {Scene("b"), point}, {Scene("c"), Point(kNowS - 15)}});
  HistoryQuery query = {.from_ms = (kNowS - 900) * 1000};
  const HistoryPage first = Read(query);
  ASSERT_EQ(first.series.size(), 1U);
  query.after = first.next;
  ASSERT_TRUE(query.after);
  const HistoryPage second = Read(query);
  ASSERT_EQ(second.series.size(), 2U);
  EXPECT_EQ(second.series[0].scene(), "b");
}

TEST_F(HistoryFileTest, SelectsByProjectSceneSessionAndKind) {
  SeriesKey session = Scene("harbour");
  session.kind = v1::HISTORY_KIND_SESSION;
  session.session = "one";
  SeriesKey other = session;
  other.session = "two";
  Add({{Scene("harbour"), Point(kNowS - 15)},
       {Scene("harbour", "other game"), Point(kNowS - 15)},
       {session, Point(kNowS - 15)},
       {other, Point(kNowS - 15)}});
  const int64_t from_ms = (kNowS - 900) * 1000;
  EXPECT_EQ(Read({.from_ms = from_ms}).series.size(), 2U);
  EXPECT_EQ(Read({.filter = {"game", ""}, .from_ms = from_ms}).series.size(), 1U);
  EXPECT_EQ(Read({.filter = {"", "", {"other game"}}, .from_ms = from_ms}).series.size(), 1U);
  const HistoryQuery query = {
      .kind = v1::HISTORY_KIND_SESSION, .session = "two", .from_ms = from_ms};
  EXPECT_EQ(ReadOne(query).session_id(), "two");
  EXPECT_EQ(
      Read({.from_ms = kNowS * 1000 + 100'000, .until_ms = kNowS * 1000 + 200'000}).series.size(),
      0U);
}

TEST_F(HistoryFileTest, ADamagedFileIsDataLoss) {
  file_.reset();
  std::ofstream(path_) << std::string(10'000, 'x');
  EXPECT_TRUE(absl::IsDataLoss(HistoryFile::Open(path_).status()));
  const auto aside = HistoryFile::SetAside(path_);
  ASSERT_TRUE(aside.ok()) << aside.status();
  EXPECT_TRUE(std::filesystem::exists(*aside));
  Open();
  Add({{Scene("harbour"), Point(kNowS - 15)}});
  EXPECT_TRUE(file_->Check().ok());
}

// A page in the middle is overwritten, which only Check and statements that read the page find.
TEST_F(HistoryFileTest, ADamagedPageIsFoundByACheck) {
  for (int i = 0; i < 300; ++i) Add({{Scene(std::to_string(i)), Point(kNowS - 15)}});
  file_.reset();
  {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    for (int page = 16; page < 32; ++page) {
      file.seekp(page * 4096);
      file << std::string(4096, 'x');
    }
  }
  Open();
  EXPECT_TRUE(absl::IsDataLoss(file_->Check()));
}

}  // namespace
}  // namespace sweepstake::history
