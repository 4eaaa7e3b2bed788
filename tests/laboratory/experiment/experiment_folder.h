// The folder of an experiment: the path of each file, the manifest with the plan, and the finished
// runs. Files are written atomically, so that an experiment can be resumed after its program was
// killed.
//
//   manifest.json   options, seeds, machine, versions, command lines, state
//   runs/           one record per finished run
//   traces/         the costs of every arm on every frame of a cell's scene
//   frames/         every frame of a run, if --frames is given
//   *.csv, tables.txt, experiment.json, report.html
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_plan.h"
#include "tests/laboratory/experiment/experiment_record.h"

namespace sweepstake::cli {

// One execution of the program on this experiment.
struct ExperimentSession {
  std::string command_line;
  std::string start_utc;
  std::string end_utc;  // empty if the program was killed
};

struct ExperimentManifest {
  ExperimentOptions options;  // defaults filled in
  std::vector<ExperimentSession> sessions;
};

class ExperimentFolder {
 public:
  explicit ExperimentFolder(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path RunFile(const PlannedRun& run) const;
  std::filesystem::path FramesFile(const PlannedRun& run) const;
  std::filesystem::path TraceFile(const ExperimentCell& cell) const;

  // Creates the folders. Error: kInvalidArgument (a folder cannot be created, or the folder already
  // contains an experiment).
  Status Create() const;
  // Reads the manifest. Errors: kNotFound (it is missing), kDataLoss (it is invalid).
  Result<ExperimentManifest> ReadManifest() const;
  // Writes the manifest; `json` is the whole document.
  Status WriteManifest(const std::string& json) const;
  // Returns the records of the finished runs in the plan's order. A record that does not match its
  // file name is skipped, so its run is repeated.
  std::vector<RunRecord> ReadRecords(const ExperimentPlan& plan) const;

 private:
  std::filesystem::path path_;
};

// Returns the manifest: options, every run's seeds, the decider's scaled parameters, machine and
// versions. `finished_count` is how many of the plan's runs are finished.
std::string ManifestJson(const ExperimentPlan& plan, const std::vector<ExperimentSession>& sessions,
                         size_t finished_count);

}  // namespace sweepstake::cli
