// The small form of a priors file, which a game ships and its repository can hold: per scene,
// machine class and build the sum over all sources, without their names.
//
// It is one JSON document with a line per scene and a line per build of the scene:
//   {"format": "sweepstake-priors", "version": 2, "checksum": "0123456789abcdef", "scenes": [
//   {"project": "p", "scene": "s", "machine_class": "m", "reward_version": 3,
//    "arms": ["Grid/1", "SAP/2"], "builds": {
//   "1.2": [1760000000, [[5.2, 4.1, 12], null], [[80.1, 62.5, 190], [75.5, 30.1, 180]]]}}]}
// An arm is NAME/BACKEND_VERSION. A build is an array: the time when one of its sources last learnt
// (seconds since 1970; 0: unknown), a cell per arm for the frame thread, and a cell per arm for the
// lane. A cell has the increments of alpha and beta (five digits), the number of windows or visits,
// and the number of bail-outs if there are any. The checksum covers the scenes, independently of
// white space.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/embedded/priors_file.h"

namespace sweepstake {

// First character of the source of a sum. No session's source begins with it.
inline constexpr char kSumMark = '*';

// Returns one sum per key and build, ordered by KeyOf. A sum's source is named after its build, and
// its sequence number is its number of windows or visits. So of two sums of a build, the one with
// more evidence counts.
std::vector<PriorRecord> SumByBuild(std::vector<PriorRecord> records);

// Returns whether the record is a sum. Stores do not import sums, because they cannot detect how
// much of a sum they already contain.
bool IsSum(const PriorRecord& record);

// REQUIRES: all records are sums with distinct keys.
std::string FormatSums(std::span<const PriorRecord> sums);

// Makes a document from records that come scene by scene, as a daemon exports them. It holds the
// records of one scene at a time.
class SumsWriter {
 public:
  SumsWriter();
  ~SumsWriter();

  // REQUIRES: the records of a scene of a project come one after the other, except those in
  // quarantine.
  void Add(PriorRecord record);

  // Returns the document; call it once. `sum_count` becomes the number of sums in it.
  std::string Finish(uint64_t& sum_count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Reads the scenes of a document, which are added one by one while the document is parsed.
class SumsReader {
 public:
  SumsReader();
  ~SumsReader();

  void Add(const nlohmann::json& scene);

  // Returns the sums of all scenes; call it once. `document` is the rest of the file, with an empty
  // array in place of the scenes. Errors: those of ParsePriors.
  Result<std::vector<PriorRecord>> Take(const nlohmann::json& document);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sweepstake
