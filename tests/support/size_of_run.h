// The size and the seed of a test with random moments: set in its source for the test suite, and by
// the environment for longer runs.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace sweepstake::test_support {

inline uint64_t FromEnvironment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace sweepstake::test_support
