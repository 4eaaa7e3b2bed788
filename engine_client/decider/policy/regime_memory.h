// Recognises a regime of the scene that returns by its descriptors.
//
// A descriptor belongs to a regime if its object count differs from the regime's mean by a factor
// of less than two, its mean speed by less than e, and its static ratio by less than 0.3. A feature
// that was not measured only matches one that was not measured. A descriptor that belongs to no
// regime begins one. It may be a mixture of the regimes before and after it, so the next new regime
// replaces one with a single descriptor.
//
// At most kMaxRegimes are held. Then the regime that was left the longest ago is forgotten. Not
// thread-safe. Deterministic.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

class RegimeMemory {
 public:
  static constexpr uint32_t kMaxRegimes = 4;

  struct Recognition {
    uint32_t regime = 0;  // < kMaxRegimes; a new regime may reuse the number of a forgotten one
    bool is_new = false;
  };
  Recognition Observe(const SceneDescriptor& descriptor);

 private:
  using Features = std::array<double, 3>;
  struct Regime {
    Features centre{};
    uint64_t count = 0;  // descriptors
    uint64_t last = 0;   // number of the latest descriptor; 0: a mixture
  };

  static Features FeaturesOf(const SceneDescriptor& descriptor);
  static double Distance(const Features& a, const Features& b);
  std::optional<uint32_t> Find(const Features& features) const;
  Recognition Begin(const Features& features);

  std::vector<Regime> regimes_;
  uint32_t current_ = 0;
  uint64_t count_ = 0;
};

}  // namespace sweepstake::decision
