// The evidence that a store must have, kept apart from it: what the commits that reached the disk
// added, each once.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::simulation {

class EvidenceModel {
 public:
  // Is told what is wrong.
  using Complain = std::function<void(const std::string&)>;

  // The store was given these updates. Of those of a commit that failed the disk may yet have all
  // or none, which the next start shows.
  void Commit(std::span<const priors::SourceUpdate> updates, bool ok);
  // Takes over what a store that was opened anew has of commits that failed.
  void Settle(priors::PriorReader& store, const Complain& complain);

  // Compares all that the store has, given all records of its export; those of files are taken for
  // right.
  void Check(priors::PriorReader& store, const priors::ExportPage& exported,
             const Complain& complain) const;
  bool has_session(const std::string& id) const { return sessions_.contains(id); }
  priors::Evidence OfSession(const std::string& id) const;

 private:
  using ByKey = std::map<priors::EvidenceKey, priors::Evidence>;
  struct Session {
    priors::SourceProgress progress;
    ByKey evidence;
    std::vector<priors::SourceUpdate> failed;  // offered after `progress`
  };
  struct Scene {
    priors::SceneEvidence evidence;
    std::set<std::string> sources;

    void Add(const std::string& source, const priors::EvidenceKey& key,
             const priors::Evidence& more);
    bool SameAs(const priors::SceneEvidence& stored) const;
  };

  static void Apply(const priors::SourceUpdate& update, Session& session);
  // Returns all scenes, those of files included.
  std::map<priors::SceneKey, Scene> Scenes(std::span<const priors::PriorRecord> exported) const;
  // Compares the records of sessions with what they had committed.
  void CheckRecords(std::span<const priors::PriorRecord> records, const Complain& complain) const;

  std::map<std::string, Session> sessions_;
};

}  // namespace sweepstake::simulation
