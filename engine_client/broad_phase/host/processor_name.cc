#include "engine_client/broad_phase/host/processor_name.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#if defined(__APPLE__)
#include <sys/sysctl.h>
#elif defined(_MSC_VER) && !defined(__clang__) && (defined(_M_X64) || defined(_M_IX86))
#include <intrin.h>
#elif defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>
#elif defined(__linux__)
#include <cstdio>
#endif

namespace sweepstake {

#if defined(__APPLE__)

std::string ProcessorName() {
  char name[128] = {};
  size_t size = sizeof name - 1;
  return sysctlbyname("machdep.cpu.brand_string", name, &size, nullptr, 0) == 0 ? name : "";
}

#elif defined(__x86_64__) || defined(__i386__) || defined(_M_X64) || defined(_M_IX86)

namespace {

using Registers = std::array<uint32_t, 4>;

Registers Cpuid(uint32_t leaf) {
  Registers found{};
#if defined(_MSC_VER) && !defined(__clang__)
  __cpuid(reinterpret_cast<int*>(found.data()), static_cast<int>(leaf));
#else
  __cpuid(leaf, found[0], found[1], found[2], found[3]);
#endif
  return found;
}

}  // namespace

// Returns the brand string: "Processor Brand String" of CPUID in the manuals of Intel and AMD. It
// ends at the first zero. Vendors pad it with blanks at either end.
std::string ProcessorName() {
  constexpr uint32_t kExtended = 0x80000000;
  std::string name;
  if (Cpuid(kExtended)[0] < kExtended + 4) return name;
  for (uint32_t leaf = kExtended + 2; leaf <= kExtended + 4; ++leaf) {
    const Registers part = Cpuid(leaf);
    name.append(reinterpret_cast<const char*>(&part), sizeof part);
  }
  name.resize(std::min(name.find('\0'), name.size()));
  name.erase(name.find_last_not_of(' ') + 1);
  return name.erase(0, name.find_first_not_of(' '));
}

#elif defined(__linux__)

// Returns the main identification register (MIDR) of the first core. Its bits encode the vendor and
// the part.
std::string ProcessorName() {
  char text[64] = {};
  std::FILE* const file =
      std::fopen("/sys/devices/system/cpu/cpu0/regs/identification/midr_el1", "re");
  if (file == nullptr) return "arm";
  const bool is_read = std::fgets(text, sizeof text, file) != nullptr;
  std::fclose(file);
  return is_read ? std::string("arm ") + text : "arm";
}

#else

std::string ProcessorName() { return "arm"; }

#endif

}  // namespace sweepstake
