// Overlapping files of priors, which are imported repeatedly and in any order, and a check of the
// store's records. If the import of a file was acknowledged, the store must have each record of the
// file, or a newer record of the same key and source. Either all records of any other file are
// there, or none. No record may occur twice.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

// The projects of all games and files.
inline const std::vector<std::string> kProjects = {"north", "south"};

class PriorFiles {
 public:
  explicit PriorFiles(World& world) : world_(world) {}

  // Returns the index of a new file or, sometimes, of an earlier one.
  size_t Choose();
  const std::vector<priors::PriorRecord>& records(size_t file) const { return files_[file]; }
  // Called when the daemon has acknowledged the import of the file.
  void MarkPromised(size_t file) { promised_[file] = true; }

  // Checks all records of a store, also records of sessions. Calls `complain` for each error.
  void Check(std::span<const priors::PriorRecord> stored,
             const std::function<void(const std::string&)>& complain) const;

 private:
  void Make();

  World& world_;
  std::vector<std::vector<priors::PriorRecord>> files_;
  std::vector<bool> promised_;
};

}  // namespace sweepstake::simulation
