// The size and the seed of a test whose events happen at random moments. Each test sets defaults
// for the test suite; environment variables set them for longer runs.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace sweepstake::test_support {

inline uint64_t FromEnvironment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace sweepstake::test_support
