// The evidence that a store must contain, computed independently of the store: the sum of the
// commits that reached the disk, each counted once.
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
  // Called with a description of each error.
  using Complain = std::function<void(const std::string&)>;

  // Records updates that were passed to the store. If the commit failed, the disk has either all of
  // them or none; Settle determines this after the next start.
  void Commit(std::span<const priors::SourceUpdate> updates, bool ok);
  // Determines which failed commits a reopened store contains.
  void Settle(priors::PriorReader& store, const Complain& complain);

  // Compares the whole store with the model, given all records of its export. Records of files are
  // assumed to be correct.
  void Check(priors::PriorReader& store, const priors::ExportPage& exported,
             const Complain& complain) const;
  bool has_session(const std::string& id) const { return sessions_.contains(id); }
  priors::Evidence OfSession(const std::string& id) const;

 private:
  using ByKey = std::map<priors::EvidenceKey, priors::Evidence>;
  struct Session {
    priors::SourceProgress progress;
    ByKey evidence;
    std::vector<priors::SourceUpdate> failed;  // failed commits since `progress`
  };
  struct Scene {
    priors::SceneEvidence evidence;
    std::set<std::string> sources;

    void Add(const std::string& source, const priors::EvidenceKey& key,
             const priors::Evidence& more);
    bool SameAs(const priors::SceneEvidence& stored) const;
  };

  static void Apply(const priors::SourceUpdate& update, Session& session);
  // Returns all scenes, including the scenes of imported files.
  std::map<priors::SceneKey, Scene> Scenes(std::span<const priors::PriorRecord> exported) const;
  // Compares the records of sessions with the commits of the sessions.
  void CheckRecords(std::span<const priors::PriorRecord> records, const Complain& complain) const;

  std::map<std::string, Session> sessions_;
};

}  // namespace sweepstake::simulation
