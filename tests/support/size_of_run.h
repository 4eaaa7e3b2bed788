// How much a test with random moments does, and from which seed: in the suite what its source says,
// in a longer run what the environment says.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace sweepstake::test_support {

inline uint64_t FromEnvironment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace sweepstake::test_support
