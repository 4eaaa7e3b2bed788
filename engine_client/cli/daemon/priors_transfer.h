// Reads a daemon's evidence, and adds to it, through the PriorsService.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ImportResult {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
  // Of these, those that the daemon does not have under their project and scene: it knows their
  // sources under others, or has revoked them. 0 as well where the daemon does not let us look.
  uint64_t absent_count = 0;
};

// What to export: what counts and what waits in quarantine, or the latter alone.
enum class Exported : uint8_t { kAll, kQuarantined };

// An empty `project` or `scene` selects all. Error: kUnavailable (no daemon answered).
Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene,
                                              Exported what = Exported::kAll);
// Hands over the records one by one as they come: scene by scene, what waits behind all that
// counts.
Status StreamPriors(const DaemonOptions& daemon, const std::string& project,
                    const std::string& scene, Exported what,
                    const std::function<void(PriorRecord)>& on_record);
// Adds all records or, on an error, none: to the quarantine, or with `promote` so that they count.
Result<ImportResult> ImportPriors(const DaemonOptions& daemon, std::span<const PriorRecord> records,
                                  bool promote = false);

// Which sources: those that match all that is set.
struct SourceChoice {
  std::string project = {};
  std::string source_id = {};
  std::string build = {};
  int64_t token_id = 0;
  int64_t unix_from_s = 0;
  int64_t unix_until_s = 0;

  friend bool operator==(const SourceChoice&, const SourceChoice&) = default;
};

// A scene in which another arm would be the one that is believed to cost least; empty: none.
struct LeaderChange {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 0;
  std::string arm;
  std::string next_arm;
};

// Of a preview.
struct LeaderChanges {
  std::vector<LeaderChange> scenes;  // the first 20
  uint64_t scene_count = 0;
};

struct RevokeResult {
  uint64_t source_count = 0;
  uint64_t record_count = 0;
  uint64_t window_count = 0;
  LeaderChanges leader_changes = {};
};

struct PromoteResult {
  uint64_t source_count = 0;
  uint64_t record_count = 0;
  uint64_t window_count = 0;
  uint64_t scene_count = 0;
  LeaderChanges leader_changes = {};
};

// Lets what waits of them count or, with `preview`, only says what that would be.
Result<PromoteResult> PromotePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                    bool preview);

// Takes their evidence out of the daemon or, with `preview`, only says what that would be.
Result<RevokeResult> RevokePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                  bool preview);

}  // namespace sweepstake::cli
