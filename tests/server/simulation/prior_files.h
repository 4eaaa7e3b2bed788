// Files of priors that overlap, are imported again and in another order than they were made, and
// what the store must have of them: of each whole file that was promised everything or something
// newer, of the others everything or nothing, and of each record one copy.
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

  // Returns the index of a new file or, at times, of an earlier one.
  size_t Choose();
  const std::vector<priors::PriorRecord>& records(size_t file) const { return files_[file]; }
  // The daemon has said that the file is imported.
  void MarkPromised(size_t file) { promised_[file] = true; }

  // Takes all records of a store, sessions' included. `complain` is told what is wrong.
  void Check(std::span<const priors::PriorRecord> stored,
             const std::function<void(const std::string&)>& complain) const;

 private:
  void Make();

  World& world_;
  std::vector<std::vector<priors::PriorRecord>> files_;
  std::vector<bool> promised_;
};

}  // namespace sweepstake::simulation
