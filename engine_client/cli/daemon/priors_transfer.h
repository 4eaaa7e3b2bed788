// Reads, adds, promotes and revokes a daemon's evidence through the PriorsService.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ImportCounts {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
  // The unchanged records that the daemon does not have under their project and scene, because
  // their source was revoked or is stored under another project or scene. Also 0 if the daemon's
  // evidence cannot be read.
  uint64_t absent_count = 0;
};

// Selects what to export: all records including those in quarantine, or only those in quarantine.
enum class Exported : uint8_t { kAll, kQuarantined };

// Returns the records of a daemon. An empty `project` or `scene` selects all. Error: kUnavailable
// (no daemon answered).
Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene,
                                              Exported what = Exported::kAll);
// Calls `on_record` with each record as it arrives: scene by scene, and all quarantined records
// after all others.
Status StreamPriors(const DaemonOptions& daemon, const std::string& project,
                    const std::string& scene, Exported what,
                    const std::function<void(PriorRecord)>& on_record);
// Adds all records or, on an error, none. They go to the quarantine or, with `promote`, count at
// once.
Result<ImportCounts> ImportPriors(const DaemonOptions& daemon, std::span<const PriorRecord> records,
                                  bool promote = false);

// Selects the sources that match all fields that are set.
struct SourceChoice {
  std::string project = {};
  std::string source_id = {};
  std::string build = {};
  int64_t token_id = 0;
  int64_t unix_from_s = 0;
  int64_t unix_until_s = 0;

  friend bool operator==(const SourceChoice&, const SourceChoice&) = default;
};

// A scene in which the arm with the least expected cost would change from `arm` to `next_arm`. An
// empty name means none.
struct LeaderChange {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 0;
  std::string arm;
  std::string next_arm;
};

// The scenes in which a revocation or promotion would change the leading arm. Set only by a
// preview.
struct LeaderChanges {
  std::vector<LeaderChange> scenes;  // at most the first 20
  uint64_t scene_count = 0;
};

struct RevokeCounts {
  uint64_t source_count = 0;
  uint64_t record_count = 0;
  uint64_t window_count = 0;
  LeaderChanges leader_changes = {};
};

struct PromoteCounts {
  uint64_t source_count = 0;
  uint64_t record_count = 0;
  uint64_t window_count = 0;
  uint64_t scene_count = 0;
  LeaderChanges leader_changes = {};
};

// Makes quarantined evidence of the sources count. With `preview` it only returns what would
// change.
Result<PromoteCounts> PromotePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                    bool preview);

// Removes the evidence of the sources from the daemon. With `preview` it only returns what would
// change.
Result<RevokeCounts> RevokePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                  bool preview);

}  // namespace sweepstake::cli
