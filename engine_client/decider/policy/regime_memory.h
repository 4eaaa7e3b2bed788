// Assigns each scene descriptor to a regime, and recognises a regime when it returns.
//
// A descriptor is compared with the mean of a regime. It belongs to the regime if three features
// are similar: the object count within a factor of two, the mean speed within a factor of e, and
// the static ratio within 0.3. A feature that was not measured matches only a feature that was not
// measured.
//
// A descriptor that belongs to no known regime begins a new one.
//
// At most kMaxRegimes are kept. If all places are taken, a new regime replaces the regime whose
// latest descriptor is the oldest. Not thread-safe. Deterministic.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/policy/regime_report.h"
#include "engine_client/decider/regime_span.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

class RegimeMemory {
 public:
  static constexpr uint32_t kMaxRegimes = 4;

  struct Recognition {
    uint32_t regime = 0;  // < kMaxRegimes; a new regime may reuse the number of a forgotten one
    bool is_new = false;
  };
  // Assigns the descriptor to a regime, which becomes the present one.
  Recognition Observe(const SceneDescriptor& descriptor);
  // Returns which regime Observe would assign the descriptor to. The first descriptor matches the
  // present regime.
  DescriptorMatch Match(const SceneDescriptor& descriptor) const;

  // Before the first descriptor, place 0 has a regime with number 0 and an unmeasured centre.
  RegimeId IdAt(uint32_t place) const;
  RegimeCentre CentreAt(uint32_t place) const { return CentreOf(FeaturesAt(place)); }
  // The centre as features. A descriptor without a value stands for an unmeasured centre.
  RegimeFeatures FeaturesAt(uint32_t place) const {
    return place < regimes_.size() ? regimes_[place].centre : FeaturesOf({});
  }

 private:
  struct Regime {
    RegimeFeatures centre{};
    uint32_t number = 0;  // number of regimes that began before it
    uint64_t count = 0;   // number of descriptors assigned to it
    uint64_t last = 0;    // number of its latest descriptor
  };

  std::optional<uint32_t> Find(const RegimeFeatures& features) const;
  Recognition Begin(const RegimeFeatures& features);

  std::vector<Regime> regimes_;
  uint32_t current_ = 0;
  uint32_t begun_count_ = 0;  // number of regimes that have begun
  uint64_t count_ = 0;
};

}  // namespace sweepstake::decision
