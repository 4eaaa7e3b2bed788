#include "server/history/history_file.h"

#include <algorithm>
#include <map>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "server/storage/private_file.h"

namespace sweepstake::history {
namespace {

namespace fs = std::filesystem;
using storage::SqlRow;

constexpr int64_t kApplicationId = 1398887240;  // "SwsH"
constexpr int64_t kVersion = 1;
// The step of the one point of each series that contains all of its points.
constexpr int64_t kWholeLife = 0;
// A point may begin this much later than now, because the wall clock can have been set back.
constexpr int64_t kMaxAheadS = 86'400;

constexpr const char* kSchema = R"sql(
    CREATE TABLE series (
      id INTEGER PRIMARY KEY,
      kind INTEGER NOT NULL,
      project TEXT NOT NULL,
      scene TEXT NOT NULL,
      machine_class TEXT NOT NULL,
      reward_version INTEGER NOT NULL,
      build TEXT NOT NULL,
      session TEXT NOT NULL,
      seen_s INTEGER NOT NULL,
      UNIQUE (kind, project, scene, machine_class, reward_version, build, session)
    ) STRICT;
    CREATE INDEX series_by_age ON series (seen_s);
    CREATE INDEX series_by_session ON series (session) WHERE session <> '';
    CREATE TABLE point (
      series_id INTEGER NOT NULL,
      step_s INTEGER NOT NULL,
      start_s INTEGER NOT NULL,
      bytes BLOB NOT NULL,
      PRIMARY KEY (series_id, step_s, start_s)
    ) STRICT, WITHOUT ROWID;
    CREATE INDEX point_by_age ON point (step_s, start_s))sql";

constexpr const char* kAddSeries = R"sql(
    INSERT INTO series (kind, project, scene, machine_class, reward_version, build, session, seen_s)
    VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)
    ON CONFLICT DO UPDATE SET seen_s = max(seen_s, excluded.seen_s) RETURNING id)sql";
constexpr const char* kFindPoint =
    "SELECT bytes FROM point WHERE series_id = ?1 AND step_s = ?2 AND start_s = ?3";
constexpr const char* kPutPoint =
    "INSERT OR REPLACE INTO point (series_id, step_s, start_s, bytes) VALUES (?1, ?2, ?3, ?4)";
constexpr const char* kSelectPoints = R"sql(
    SELECT start_s, bytes FROM point
    WHERE series_id = ?1 AND step_s = ?2 AND start_s > ?3 AND start_s < ?4 ORDER BY start_s)sql";
constexpr const char* kFirstPoint =
    "SELECT coalesce(min(start_s), 0) FROM point WHERE series_id = ?1 AND step_s = ?2";
constexpr const char* kLatestSeries = "SELECT coalesce(max(seen_s), 0) FROM series";
// Removes points that were made while the wall clock was ahead.
constexpr const char* kRemoveFuturePoints = "DELETE FROM point WHERE step_s = ?1 AND start_s > ?2";
constexpr const char* kClampSeries = "UPDATE series SET seen_s = ?1 WHERE seen_s > ?1";
constexpr const char* kCountPoints = "SELECT step_s, count(*) FROM point GROUP BY step_s";
// The project and the kind of series with the most points of a step.
constexpr const char* kLargestOwner = R"sql(
    SELECT project, kind, count(*) AS c FROM point JOIN series ON id = series_id WHERE step_s = ?1
    GROUP BY project, kind ORDER BY c DESC LIMIT 1)sql";
constexpr const char* kRemoveOldestPoints = R"sql(
    DELETE FROM point WHERE (series_id, step_s, start_s) IN (
      SELECT series_id, step_s, start_s FROM point JOIN series ON id = series_id
      WHERE step_s = ?1 AND project = ?2 AND kind = ?3 ORDER BY start_s LIMIT ?4))sql";
constexpr const char* kRemoveOldestSeries = R"sql(
    DELETE FROM series WHERE id IN (
      SELECT id FROM series WHERE seen_s < ?1 AND project = ?2 AND kind = ?3
      ORDER BY seen_s LIMIT ?4))sql";
constexpr const char* kRemoveLostPoints =
    "DELETE FROM point WHERE series_id NOT IN (SELECT id FROM series)";
constexpr const char* kRemovePoints = "DELETE FROM point WHERE step_s = ?1 AND start_s < ?2";
constexpr const char* kRemoveLives = R"sql(
    DELETE FROM point WHERE series_id IN (SELECT id FROM series WHERE seen_s < ?1))sql";
constexpr const char* kRemoveSeries = "DELETE FROM series WHERE seen_s < ?1";

std::string SchemaText() {
  return absl::StrCat(kSchema, "; PRAGMA application_id = ", kApplicationId,
                      "; PRAGMA user_version = ", kVersion);
}

// Returns the statement that selects series, of one session only if `condition` says so.
std::string SelectText(const char* condition) {
  return absl::StrCat(R"sql(
    SELECT id, project, scene, machine_class, reward_version, build, session FROM series
    WHERE kind = ?1 AND (?2 = '' OR project = ?2) AND (?3 = '' OR scene = ?3) AND )sql",
                      condition, R"sql( AND seen_s >= ?5
      AND (?6 = '' OR instr(?6, char(10) || project || char(10)))
      AND (?14 = 0 OR (reward_version = ?14 AND machine_class = ?15))
      AND (project, scene, machine_class, reward_version, build, session)
        > (?7, ?8, ?9, ?10, ?11, ?12)
    ORDER BY project, scene, machine_class, reward_version, build, session LIMIT ?13)sql");
}

// A statement is identified by its address, so both live as long as the program. The second one
// uses the index series_by_session.
const char* SelectSeries(bool is_of_session) {
  static const std::string& all = *new std::string(SelectText("?4 = ''"));
  static const std::string& one = *new std::string(SelectText("session <> '' AND session = ?4"));
  return (is_of_session ? one : all).c_str();
}

SeriesKey KeyOf(v1::HistoryKind kind, const SqlRow& row) {
  return {.kind = kind,
          .scene = {row.Text(1), row.Text(2), row.Text(3), row.Small(4)},
          .build = row.Text(5),
          .session = row.Text(6)};
}

// Adds points to a series. Adds up adjacent points, so that the series has at most `max_points`.
class PointSum {
 public:
  // `from_s` and the points are multiples of `step_s`.
  PointSum(int64_t from_s, int64_t until_s, int64_t step_s, uint32_t max_points,
           v1::HistorySeries& series)
      : from_s_(from_s), series_(series) {
    const int64_t count = (until_s - from_s + step_s - 1) / step_s;
    width_s_ = step_s * std::max<int64_t>(1, (count + max_points - 1) / max_points);
  }

  void Add(int64_t start_s, const std::string& bytes) {
    v1::HistoryPoint point;
    if (!point.ParseFromString(bytes)) return;
    const int64_t place = (start_s - from_s_) / width_s_;
    if (series_.points_size() == 0 || place != last_place_) series_.add_points();
    last_place_ = place;
    history::Add(point, *series_.mutable_points()->rbegin());
  }

 private:
  const int64_t from_s_;
  int64_t width_s_;
  v1::HistorySeries& series_;
  int64_t last_place_ = 0;
};

}  // namespace

absl::StatusOr<fs::path> HistoryFile::SetAside(const fs::path& path) {
  fs::path aside = path.string() + ".damaged";
  std::error_code error;
  fs::rename(path, aside, error);
  if (error)
    return absl::UnavailableError(absl::StrCat("cannot rename ", path.string(), " to ",
                                               aside.string(), ": ", error.message()));
  return aside;
}

absl::StatusOr<std::unique_ptr<HistoryFile>> HistoryFile::Open(const fs::path& path) {
  std::error_code unknown;  // a file that cannot be examined cannot be opened either
  const bool is_new = !fs::exists(path, unknown);
  if (is_new) {
    if (absl::Status status = storage::CreatePrivateFile(path); !status.ok()) return status;
  }
  auto database =
      storage::SqliteDatabase::Open(path.string(), storage::SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return storage::Explain(path, database.status());
  absl::Status status = database->Configure();
  auto table_count =
      status.ok() ? database->QueryInteger("SELECT count(*) FROM sqlite_schema") : status;
  if (table_count.ok() && *table_count == 0) {
    // Most points have about 1 kB, which would need a page of their own at the default size.
    status = database->Execute("PRAGMA page_size = 16384; VACUUM");
    if (status.ok())
      status = InTransaction(*database, [&] { return database->Execute(SchemaText()); });
    if (!status.ok()) return storage::Explain(path, status);
  }
  if (!table_count.ok()) return storage::Explain(path, table_count.status());
  const auto owner = database->QueryInteger("PRAGMA application_id");
  const auto version = database->QueryInteger("PRAGMA user_version");
  if (!owner.ok() || !version.ok()) return storage::Explain(path, version.status());
  if (*owner != kApplicationId || *version != kVersion)
    return absl::DataLossError(absl::StrCat("it is not a history of version ", kVersion));
  storage::FilesInUse files;
  if (status = files.Add(path, /*may_shrink=*/true); !status.ok()) return status;
  return std::unique_ptr<HistoryFile>(new HistoryFile(*std::move(database), std::move(files)));
}

absl::Status HistoryFile::Check() {
  const auto check = database_.QueryText("PRAGMA quick_check(1)");
  if (!check.ok()) return check.status();
  return *check == "ok" ? absl::OkStatus() : absl::DataLossError(*check);
}

absl::Status HistoryFile::Add(const std::vector<HistoryEntry>& entries, const HistoryLimits& limits,
                              int64_t unix_now_s, int64_t steady_ns) {
  if (absl::Status place = files_.Check(); !place.ok()) return place;
  return InTransaction(database_, [&] {
    absl::Status status;
    for (size_t i = 0; i < entries.size() && status.ok(); ++i) status = AddOne(entries[i]);
    return status.ok() ? Trim(limits, unix_now_s, steady_ns) : status;
  });
}

absl::Status HistoryFile::AddOne(const HistoryEntry& entry) {
  const auto& [key, point] = entry;
  const auto id = SeriesId(key, point.end_unix_ms() / 1000);
  if (!id.ok()) return id.status();
  const auto add = [&](int64_t step_s) {
    const int64_t second = point.unix_ms() / 1000;
    const int64_t start_s = step_s == kWholeLife ? 0 : second - second % step_s;
    v1::HistoryPoint sum;
    absl::Status status = database_.ForEachRow(
        kFindPoint, [&](const SqlRow& row) { (void)sum.ParseFromString(row.Bytes(0)); }, *id,
        step_s, start_s);
    if (!status.ok()) return status;
    history::Add(point, sum);
    if (step_s == kWholeLife) sum.clear_activity();
    const std::string bytes = sum.SerializeAsString();
    return database_.Run(kPutPoint, *id, step_s, start_s, storage::SqlBytes{bytes});
  };
  absl::Status status = add(kWholeLife);
  for (const Resolution& resolution : kResolutions)
    if (status.ok()) status = add(resolution.step_s);
  return status;
}

absl::StatusOr<int64_t> HistoryFile::SeriesId(const SeriesKey& key, int64_t seen_s) {
  return database_.ReadInteger(kAddSeries, static_cast<int>(key.kind), key.scene.project,
                               key.scene.scene, key.scene.machine_class, key.scene.reward_version,
                               key.build, key.session, seen_s);
}

absl::Status HistoryFile::Trim(const HistoryLimits& limits, int64_t unix_now_s, int64_t steady_ns) {
  if (!clock_) {
    const auto latest = database_.ReadInteger(kLatestSeries);
    if (!latest.ok()) return latest.status();
    clock_.emplace(static_cast<uint64_t>(*latest));
  }
  const auto now_s =
      static_cast<int64_t>(clock_->Follow(static_cast<uint64_t>(unix_now_s), steady_ns));
  const auto most_s = static_cast<int64_t>(limits.age_s);
  absl::Status status = database_.Run(kClampSeries, now_s + kMaxAheadS);
  if (!status.ok()) return status;
  for (const auto& [step_s, age_s] : kResolutions) {
    const int64_t kept_s = age_s == 0 ? most_s : std::min(age_s, most_s);
    status = database_.Run(kRemovePoints, step_s, now_s - kept_s);
    if (status.ok()) status = database_.Run(kRemoveFuturePoints, step_s, now_s + kMaxAheadS);
    if (!status.ok()) return status;
  }
  status = database_.Run(kRemoveLives, now_s - most_s);
  if (status.ok()) status = database_.Run(kRemoveSeries, now_s - most_s);
  if (!status.ok()) return status;
  while (true) {
    const auto used = database_.UsedBytes();
    if (!used.ok()) return used.status();
    if (*used <= limits.bytes) return absl::OkStatus();
    if (status = RemoveOldest(now_s); !status.ok()) return status;
    const auto left = database_.UsedBytes();
    if (!left.ok() || *left >= *used) return left.status();
  }
}

absl::Status HistoryFile::RemoveOldest(int64_t now_s) {
  std::map<int64_t, int64_t> counts;  // of points, by step
  absl::Status status = database_.ForEachRow(
      kCountPoints, [&](const SqlRow& row) { counts[row.Integer(0)] = row.Integer(1); });
  int64_t most = 0;
  for (const auto& [step_s, count] : counts) most = std::max(most, count);
  int64_t step_s = kWholeLife;
  for (const Resolution& resolution : kResolutions) {
    if (step_s == kWholeLife && most > 0 && 2 * counts[resolution.step_s] >= most)
      step_s = resolution.step_s;
  }
  std::string project;
  int64_t kind = 0;
  int64_t count = 0;
  if (status.ok())
    status = database_.ForEachRow(
        kLargestOwner,
        [&](const SqlRow& row) {
          project = row.Text(0);
          kind = row.Integer(1);
          count = row.Integer(2) / 8 + 1;
        },
        step_s);
  if (!status.ok()) return status;
  if (step_s != kWholeLife) return database_.Run(kRemoveOldestPoints, step_s, project, kind, count);
  // Series that are still played stay, with their whole lives.
  const int64_t end_s = now_s - kResolutions.front().age_s;
  status = database_.Run(kRemoveOldestSeries, end_s, project, kind, count);
  return status.ok() ? database_.Run(kRemoveLostPoints) : status;
}

absl::StatusOr<HistoryPage> HistoryFile::Read(const HistoryQuery& query, int64_t unix_now_s) {
  if (absl::Status place = files_.Check(); !place.ok()) return place;
  const SeriesKey after = query.after.value_or(SeriesKey());  // no project: before all series
  std::vector<std::pair<int64_t, SeriesKey>> found;
  absl::Status status = database_.ForEachRow(
      SelectSeries(!query.session.empty()),
      [&](const SqlRow& row) { found.emplace_back(row.Integer(0), KeyOf(query.kind, row)); },
      static_cast<int>(query.kind), query.filter.project, query.filter.scene, query.session,
      query.from_ms / 1000, storage::LineList(query.filter.projects), after.scene.project,
      after.scene.scene, after.scene.machine_class, after.scene.reward_version, after.build,
      after.session, kMaxSeriesPerPage, query.reward_version, query.machine_class);
  HistoryPage page;
  size_t bytes = 0;
  for (const auto& [id, key] : found) {
    if (!status.ok()) return status;
    v1::HistorySeries series;
    series.set_project(key.scene.project);
    series.set_scene(key.scene.scene);
    series.set_machine_class(key.scene.machine_class);
    series.set_reward_version(key.scene.reward_version);
    series.set_build(key.build);
    series.set_session_id(key.session);
    status = ReadPoints(id, query, unix_now_s, series);
    if (query.max_points == 1) {
      for (v1::HistoryPoint& point : *series.mutable_points()) point.clear_activity();
    }
    bytes += series.ByteSizeLong();
    if (bytes > kMaxPageBytes && !page.series.empty()) return page;
    page.next = key;
    if (series.points_size() > 0) page.series.push_back(std::move(series));
  }
  if (!status.ok()) return status;
  if (found.size() < kMaxSeriesPerPage) page.next.reset();
  return page;
}

absl::Status HistoryFile::ReadPoints(int64_t series_id, const HistoryQuery& query,
                                     int64_t unix_now_s, v1::HistorySeries& series) {
  int64_t from_s = query.from_ms / 1000;
  const bool is_until_now = query.until_ms == 0;
  const int64_t until_s = is_until_now ? unix_now_s : (query.until_ms - 1) / 1000 + 1;
  if (from_s == 0 && query.max_points == 1 && is_until_now) {
    PointSum sum(0, 1, 1, 1, series);
    return database_.ForEachRow(
        kSelectPoints, [&](const SqlRow& row) { sum.Add(0, row.Bytes(1)); }, series_id, kWholeLife,
        -1, 1);
  }
  Resolution used = kResolutions.back();
  if (from_s == 0) {
    const auto first = database_.ReadInteger(kFirstPoint, series_id, used.step_s);
    if (!first.ok()) return first.status();
    from_s = *first;
  }
  // A coarser resolution is enough if its points are not longer than those of the answer.
  for (auto each = kResolutions.rbegin(); each != kResolutions.rend(); ++each) {
    const bool covers = each->age_s == 0 || from_s >= unix_now_s - each->age_s;
    const bool is_finer_needed =
        used.step_s * static_cast<int64_t>(query.max_points) > until_s - from_s;
    if (covers && is_finer_needed) used = *each;
  }
  PointSum sum(from_s - from_s % used.step_s, until_s, used.step_s, query.max_points, series);
  return database_.ForEachRow(
      kSelectPoints, [&](const SqlRow& row) { sum.Add(row.Integer(0), row.Bytes(1)); }, series_id,
      used.step_s, from_s - used.step_s, until_s);
}

}  // namespace sweepstake::history
