// What a change of the evidence would do to the arms that scenes are believed to cost least with:
// the leaders as they are are compared with those in the store as it would be. It is used on the
// store's thread.
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/priors.pb.h"

namespace sweepstake::rpc {

class LeaderPreview {
 public:
  // Reads the leaders of the project, or of all if it is empty, where `is_preview`. A scene costs a
  // read before the change and one after it; beyond kMaxScenes none is read.
  LeaderPreview(priors::PriorReader& store, std::string project, bool is_preview);

  // Returns what the store's method takes for `preview`; it must not outlive this object.
  priors::Preview preview();
  // Returns the differences; none where it is no preview. Errors: those of PriorReader::List.
  absl::StatusOr<v1::LeaderChanges> Changes() const;

 private:
  static constexpr size_t kMaxScenes = 10'000;
  static constexpr int kMaxTold = 20;
  using Leaders = std::map<priors::SceneKey, std::string>;

  absl::StatusOr<Leaders> Load(priors::PriorReader& store) const;

  const std::string project_;
  const bool is_preview_;
  absl::StatusOr<Leaders> before_ = Leaders();
  absl::StatusOr<Leaders> after_ = Leaders();
};

}  // namespace sweepstake::rpc
