// The floating-point environment in which the library computes: it rounds to nearest, keeps
// subnormal numbers and traps no exception. A game or a plug-in may have set another one.
//
// Every function of the library that a game calls, and that computes with floating-point numbers,
// begins with the following line. In AdaptiveBroadPhase::EndFrame, the few computations do.
//
//   const FloatEnvironmentScope scope;
//
// The threads of the library call SetDefaultFloatEnvironment instead (NoteThreadStarted). Callbacks
// of the game run in the library's environment, those of FrameSink in either. Cost: reading one
// register, 4 to 5 ns, if the caller's environment is the default one; about 10 ns otherwise.
//
// Not covered: the control word of the x87 unit, because the library has no long double.
#pragma once

#include <atomic>
#include <cstdint>

#if defined(__x86_64__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

namespace sweepstake {
namespace float_environment {

#if defined(__x86_64__) || defined(_M_X64)

// MXCSR (Intel SDM vol. 1, 10.2.3). Bits 0 to 5 are sticky flags, which do not alter results.
using Register = uint32_t;
inline constexpr Register kControlBits = 0xFFC0;
inline constexpr Register kDefault = 0x1F80;
inline Register Read() noexcept { return _mm_getcsr(); }
inline void Write(Register value) noexcept { _mm_setcsr(value); }
inline Register ControlOf(Register value) noexcept { return value & kControlBits; }

#elif defined(__aarch64__)

// FPCR (Arm Architecture Reference Manual, C5.2.8). The flags are in another register.
using Register = uint64_t;
inline constexpr Register kDefault = 0;
inline Register Read() noexcept {
  Register value;
  asm volatile("mrs %0, fpcr" : "=r"(value));
  return value;
}
inline void Write(Register value) noexcept { asm volatile("msr fpcr, %0" : : "r"(value)); }
inline Register ControlOf(Register value) noexcept { return value; }

#else

// WebAssembly has only the default environment.
using Register = uint32_t;
inline constexpr Register kDefault = 0;
inline Register Read() noexcept { return kDefault; }
inline void Write(Register /*value*/) noexcept {}
inline Register ControlOf(Register value) noexcept { return value; }

#endif

}  // namespace float_environment

// Sets the default environment of the calling thread.
inline void SetDefaultFloatEnvironment() noexcept {
  float_environment::Write(float_environment::kDefault);
}

// Computes in the default environment until the end of the scope, which restores the caller's.
class FloatEnvironmentScope {
 public:
  FloatEnvironmentScope() noexcept
      : callers_(float_environment::Read()),
        is_default_(float_environment::ControlOf(callers_) == float_environment::kDefault) {
    if (is_default_) return;
    SetDefaultFloatEnvironment();
    // The compiler must not move loads, and so the computations with them, before this line.
    std::atomic_signal_fence(std::memory_order_seq_cst);
  }
  ~FloatEnvironmentScope() {
    if (is_default_) return;
    std::atomic_signal_fence(std::memory_order_seq_cst);
    float_environment::Write(callers_);
  }
  FloatEnvironmentScope(const FloatEnvironmentScope&) = delete;
  FloatEnvironmentScope& operator=(const FloatEnvironmentScope&) = delete;

 private:
  const float_environment::Register callers_;
  const bool is_default_;
};

}  // namespace sweepstake
