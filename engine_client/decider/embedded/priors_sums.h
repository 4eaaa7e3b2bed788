// The small form of a priors file, which a game's repository holds and the game ships: what all
// sources of a build taught about a scene on one class of machines, without naming them.
//
// It is one JSON document with a line per scene and per build of it:
//   {"format": "sweepstake-priors", "version": 2, "checksum": "0123456789abcdef", "scenes": [
//   {"project": "p", "scene": "s", "machine_class": "m", "reward_version": 3,
//    "arms": ["Grid/1", "SAP/2"], "builds": {
//   "1.2": [1760000000, [[5.2, 4.1, 12], null], [[80.1, 62.5, 190], [75.5, 30.1, 180]]]}}]}
// The arms have their backend versions. A build has the time when it taught last (since 1970, in
// seconds; 0: unknown), then, of each arm, what the frame thread measured and what the lane did:
// what is added to alpha and beta, with five digits, the count of windows or visits, and the
// bail-outs, if any. The checksum is that of the scenes, whatever white space is between them.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/embedded/priors_file.h"

namespace sweepstake {

// What the source of a sum begins with, and that of no session.
inline constexpr char kSumMark = '*';

// Returns the sums, ordered by KeyOf. The source of each has a name by its build, and the windows
// and visits for its sequence number, so that of two sums of a build the one that has more of them
// counts.
std::vector<PriorRecord> SumByBuild(std::vector<PriorRecord> records);

// Returns whether the record is such a sum: a store cannot know what of it it has already.
bool IsSum(const PriorRecord& record);

// REQUIRES: all are sums, no two of one key.
std::string FormatSums(std::span<const PriorRecord> sums);

// Makes the document of records that come scene by scene, as a daemon exports them, and holds those
// of one scene at a time.
class SumsWriter {
 public:
  SumsWriter();
  ~SumsWriter();

  // REQUIRES: those of a scene of a project, but for what waits in quarantine, come one after the
  // other.
  void Add(PriorRecord record);

  // Returns the document, once. `sum_count` is the number of sums in it.
  std::string Finish(uint64_t& sum_count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Reads the scenes of a document, which are added one by one as they are parsed.
class SumsReader {
 public:
  SumsReader();
  ~SumsReader();

  void Add(const nlohmann::json& scene);

  // Returns the sums of all scenes, once. `document` has what is beside them, and an empty array
  // for them. Errors: as ParsePriors has them.
  Result<std::vector<PriorRecord>> Take(const nlohmann::json& document);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sweepstake
