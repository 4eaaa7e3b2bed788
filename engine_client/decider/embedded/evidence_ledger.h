// The evidence of an embedded decider: the priors it was given, and what it has learnt since, which
// it adds to records of its own source.
//
// A source that the priors know already goes on: its records grow and their sequence numbers rise,
// so that a store that has an earlier export takes the later one in its place. Not thread-safe.
// Memory: that of the records given, and one more per arm.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/pooling/source_prior.h"
#include "engine_client/decider/types.h"

namespace sweepstake {

// Returns all records of both. Of a record that both have, the one with the higher sequence number
// counts.
std::vector<PriorRecord> Unite(std::vector<PriorRecord> records, std::vector<PriorRecord> others);

class EvidenceLedger {
 public:
  // What the decider's own records have in common.
  struct Key {
    std::string project;
    std::string scene;
    std::string machine_class;
    uint32_t reward_version = 1;
    std::string source_id;
    std::string build = {};
    // Compares what sources say of the scene, and the project's scenes. REQUIRES: reward version 3.
    bool compares_sources = false;
  };

  // No two of `given` are the same evidence, as in ParsePriors and Unite. REQUIRES: as many
  // versions as arms.
  EvidenceLedger(std::vector<PriorRecord> given, Key key, std::span<const std::string> arms,
                 std::span<const uint32_t> arm_versions);

  // Returns the given evidence about each arm; all of it is 0 if there are no sources.
  std::span<const decision::EvidenceSum> given() const { return given_; }
  // Returns the same on top of Beta(1,1).
  std::vector<decision::BetaPosterior> priors() const;
  // Returns the number of sources in priors().
  uint64_t prior_source_count() const { return prior_source_count_; }

  // Adds what the decision learnt. REQUIRES: increments are of these arms.
  void Add(const decision::Decision& decision);

  // Returns all that was given with all that was added.
  const std::vector<PriorRecord>& records() const { return records_; }

 private:
  // The evidence of one scene of the project.
  struct Scene {
    std::vector<decision::ArmEvidence> arms;
    std::set<std::string> sources;
  };
  using Scenes = std::map<std::pair<std::string, std::string>, Scene>;  // by name and class

  // One source's evidence of the scene on one class of machines.
  struct Source {
    decision::SourceRelation relation;
    std::vector<decision::ArmEvidence> arms;
    std::vector<uint32_t> versions;  // of the arms; 0 where there is nothing
  };
  using Sources = std::map<std::pair<std::string, std::string>, Source>;  // by id and class

  Scenes ScenesOfProject() const;
  Sources SourcesOfScene() const;
  // Fills in what the sources of the scene say.
  void TakeSources();
  // Fills in what the project's other scenes have in common.
  void TakeOtherScenes(const Scenes& scenes);
  void TakeGiven();
  bool Applies(const PriorRecord& record, size_t arm) const;
  void Add(const decision::Increment& increment, std::string_view measured_by);
  PriorRecord& OwnRecord(size_t arm, std::string_view measured_by);

  const Key key_;
  const std::vector<std::string> arms_;
  const std::vector<uint32_t> arm_versions_;
  std::vector<PriorRecord> records_;
  uint64_t sequence_ = 0;  // the highest of the own source
  std::vector<decision::EvidenceSum> given_;
  uint64_t prior_source_count_ = 0;
};

}  // namespace sweepstake
