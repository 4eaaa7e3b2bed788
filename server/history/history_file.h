// The history's file: a SQLite database with series and their points. A point is stored once per
// resolution, and each report is added to the point of every resolution at once. So the file is
// complete at any time, and a restart continues its points.
//
// The file is not the store of evidence: a daemon whose history is lost decides as before. It is
// local to the daemon, also if several daemons share a store. Used by one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/history/history_point.h"
#include "server/storage/retention_clock.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::history {

struct HistoryLimits {
  // Maximum number of bytes in use. Above it, points are removed from the finest resolution with at
  // least half as many points as the largest one: the oldest eighth of the project and kind that
  // has the most. The file does not shrink.
  uint64_t bytes = 256ull << 20;
  uint64_t age_s = 90ull * 86'400;  // maximum age of the points of an hour, and of series

  friend bool operator==(const HistoryLimits&, const HistoryLimits&) = default;
};

// The resolutions. A point of `step_s` is kept for `age_s`, or for HistoryLimits::age_s if that is
// shorter or `age_s` is 0.
struct Resolution {
  int64_t step_s;
  int64_t age_s;
};
inline constexpr std::array<Resolution, 3> kResolutions = {
    Resolution{sessions::UseMeter::kStepMs / 1000, 2 * 3600}, Resolution{300, 8 * 86'400},
    Resolution{3600, 0}};

struct HistoryQuery {
  v1::HistoryKind kind = v1::HISTORY_KIND_SCENE;
  priors::SceneFilter filter = {};
  std::string session = {};  // empty: all
  // Selects one version of the reward and class of machines. Version 0: selects all.
  uint32_t reward_version = 0;
  std::string machine_class = {};
  int64_t from_ms = 0;   // 0: the whole history
  int64_t until_ms = 0;  // exclusive; 0: now
  uint32_t max_points = 300;
  std::optional<SeriesKey> after = {};  // only series after this one
};

struct HistoryPage {
  std::vector<v1::HistorySeries> series;
  std::optional<SeriesKey> next;  // the last series, if there may be more
};

class HistoryFile {
 public:
  // A page ends with the series that makes it larger than this.
  static constexpr size_t kMaxPageBytes = 1 << 20;
  static constexpr uint32_t kMaxSeriesPerPage = 200;

  // Opens the file; creates it if it is missing. Errors: UNAVAILABLE, DATA_LOSS (it is damaged, or
  // has another version).
  static absl::StatusOr<std::unique_ptr<HistoryFile>> Open(const std::filesystem::path& path);
  // Renames a damaged file to PATH.damaged, which replaces a former one. Returns that name. Error:
  // UNAVAILABLE.
  static absl::StatusOr<std::filesystem::path> SetAside(const std::filesystem::path& path);
  // Reads the whole file. Error: DATA_LOSS (it is damaged).
  absl::Status Check();

  // Adds each point to its series, at each resolution. All or none are added. Then removes what is
  // beyond the limits. Errors: UNAVAILABLE, DATA_LOSS, NOT_FOUND (the file was removed).
  absl::Status Add(const std::vector<HistoryEntry>& entries, const HistoryLimits& limits,
                   int64_t unix_now_s, int64_t steady_ns);
  // Returns the next series of the query with points in its period. Adjacent points are added up so
  // that a series has at most max_points; the resolution is the finest that covers the period.
  absl::StatusOr<HistoryPage> Read(const HistoryQuery& query, int64_t unix_now_s);

 private:
  HistoryFile(storage::SqliteDatabase database, storage::FilesInUse files)
      : database_(std::move(database)), files_(std::move(files)) {}

  absl::Status AddOne(const HistoryEntry& entry);
  absl::StatusOr<int64_t> SeriesId(const SeriesKey& key, int64_t seen_s);
  absl::Status Trim(const HistoryLimits& limits, int64_t unix_now_s, int64_t steady_ns);
  absl::Status RemoveOldest(int64_t now_s);
  absl::Status ReadPoints(int64_t series_id, const HistoryQuery& query, int64_t unix_now_s,
                          v1::HistorySeries& series);

  storage::SqliteDatabase database_;
  storage::FilesInUse files_;                     // finds out that the file was removed
  std::optional<storage::RetentionClock> clock_;  // absent before the first Trim
};

}  // namespace sweepstake::history
