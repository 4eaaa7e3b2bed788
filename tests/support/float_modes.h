// The floating-point environments that a game or a plug-in may have set.
//
// x86-64 (Intel SDM vol. 1, 10.2.3): four rounding modes × flush to zero × denormals are zero ×
// trapped exceptions. AArch64 (Arm ARM, FPCR): four rounding modes × flush to zero × default NaN ×
// trapped exceptions, without the traps on processors that ignore them.
#pragma once

#include <string>
#include <vector>

#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake::test_support {

struct FloatMode {
  std::string name;  // for example "up_flush_denormals_are_zero_traps"
  float_environment::Register control;
};

// Returns all modes of this processor, the default one first.
std::vector<FloatMode> FloatModes();

// Calls `body` in the mode. Returns whether the mode was still set when `body` returned.
template <typename Body>
bool KeepsMode(const FloatMode& mode, const Body& body) {
  const float_environment::Register before = float_environment::Read();
  float_environment::Write(mode.control);
  body();
  const float_environment::Register after = float_environment::Read();
  float_environment::Write(before);
  return float_environment::ControlOf(after) == float_environment::ControlOf(mode.control);
}

}  // namespace sweepstake::test_support
