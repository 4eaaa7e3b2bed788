// Previews how revoking or promoting evidence would change the leading arm of each scene. It reads
// the scenes twice: from the store as it is, and from the store as it would be after the change.
// Used on the store's writing thread.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/priors.pb.h"

namespace sweepstake::rpc {

class LeaderPreview {
 public:
  // If `is_preview`, reads the current scenes of the project (empty: of all projects). At most
  // kMaxScenes scenes are read.
  LeaderPreview(priors::PriorReader& store, std::string project, bool is_preview);

  // Returns the `preview` argument for the store's method, which must not outlive this object.
  priors::Preview preview();
  // Returns the scenes whose leading arm changes; none if this is not a preview. Errors: those of
  // PriorReader::List.
  absl::StatusOr<v1::LeaderChanges> Changes() const;

 private:
  static constexpr size_t kMaxScenes = 10'000;
  static constexpr int kMaxTold = 20;
  using Scenes = std::map<priors::SceneKey, std::vector<priors::SceneEvidence::Arm>>;

  absl::StatusOr<Scenes> Load(priors::PriorReader& store) const;

  const std::string project_;
  const bool is_preview_;
  absl::StatusOr<Scenes> before_ = Scenes();
  absl::StatusOr<Scenes> after_ = Scenes();
};

}  // namespace sweepstake::rpc
