#include "tests/support/float_modes.h"

#include <array>
#include <cstddef>
#include <string_view>

namespace sweepstake::test_support {
namespace {

using float_environment::Register;

constexpr std::array<std::string_view, 4> kRoundings = {"nearest", "down", "up", "to_zero"};

#if defined(__x86_64__) || defined(_M_X64)
constexpr std::array<Register, 4> kRoundingBits = {0, 1U << 13, 2U << 13, 3U << 13};
constexpr Register kFlush = 1U << 15;
constexpr Register kOther = 1U << 6;
constexpr std::string_view kOtherName = "_denormals_are_zero";
constexpr Register kTrapBits = 0x3FU << 7;  // set: the exception is masked
#elif defined(__aarch64__)
constexpr std::array<Register, 4> kRoundingBits = {0, 2U << 22, 1U << 22, 3U << 22};
constexpr Register kFlush = 1U << 24;
constexpr Register kOther = 1U << 25;
constexpr std::string_view kOtherName = "_default_nan";
constexpr Register kTrapBits = 0x9FU << 8;  // set: the exception is trapped
#endif

// Returns whether the processor accepts the value.
bool IsSupported(Register control) {
  const Register before = float_environment::Read();
  float_environment::Write(control);
  const Register written = float_environment::Read();
  float_environment::Write(before);
  return written == control;
}

}  // namespace

std::vector<FloatMode> FloatModes() {
  std::vector<FloatMode> modes;
  for (size_t bits = 0; bits < 32; ++bits) {
    const size_t rounding = bits >> 3;
    FloatMode mode{std::string(kRoundings[rounding]),
                   float_environment::kDefault | kRoundingBits[rounding]};
    if ((bits & 1) != 0) {
      mode.name += "_flush";
      mode.control |= kFlush;
    }
    if ((bits & 2) != 0) {
      mode.name += kOtherName;
      mode.control |= kOther;
    }
    if ((bits & 4) != 0) {
      mode.name += "_traps";
      mode.control ^= kTrapBits;
    }
    if (IsSupported(mode.control)) modes.push_back(mode);
  }
  return modes;
}

}  // namespace sweepstake::test_support
