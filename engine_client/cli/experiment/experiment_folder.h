// The folder of an experiment: where each file lies, the manifest that says what is being run, and
// which runs are there already. Files appear whole or not at all, so that a folder whose program
// was killed can be resumed.
//
//   manifest.json   options, seeds, machine, versions, command lines, state
//   runs/           a record per finished run
//   traces/         every arm on every frame of a cell's scene
//   frames/         with --frames: every frame of a run
//   *.csv, tables.txt, experiment.json, report.html
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine_client/cli/experiment/experiment_plan.h"
#include "engine_client/cli/experiment/experiment_record.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// One start of the program on this experiment.
struct ExperimentSitting {
  std::string command_line;
  std::string start_utc;
  std::string end_utc;  // empty where the program was killed
};

struct ExperimentManifest {
  ExperimentOptions options;  // defaults filled in
  std::vector<ExperimentSitting> sittings;
};

class ExperimentFolder {
 public:
  explicit ExperimentFolder(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path RunFile(const PlannedRun& run) const;
  std::filesystem::path FramesFile(const PlannedRun& run) const;
  std::filesystem::path TraceFile(const ExperimentCell& cell) const;

  // Makes the folders. kInvalidArgument: not possible, or an experiment is there already.
  Status Create() const;
  // kNotFound, kDataLoss: what is missing or broken.
  Result<ExperimentManifest> ReadManifest() const;
  // `json` is the whole document.
  Status WriteManifest(const std::string& json) const;
  // Of the planned runs those that are there, in the plan's order; records that do not fit their
  // name are passed over, and made anew.
  std::vector<RunRecord> ReadRecords(const ExperimentPlan& plan) const;

 private:
  std::filesystem::path path_;
};

// The manifest's document: options, every run's seeds, the decider's parameters as scaled, machine
// and versions. `finished_count` of the plan's runs are there.
std::string ManifestJson(const ExperimentPlan& plan, const std::vector<ExperimentSitting>& sittings,
                         size_t finished_count);

}  // namespace sweepstake::cli
