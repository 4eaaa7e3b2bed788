#include "sweepstake/machine_class.h"

#include <cctype>
#include <cstdint>
#include <string_view>
#include <thread>

#include "engine_client/broad_phase/host/processor_name.h"
#include "sweepstake/simd.h"

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>
#else
#include <unistd.h>
#endif

namespace sweepstake {
namespace {

constexpr uint64_t kGib = uint64_t{1} << 30;
constexpr uint64_t kMemoryStep = 4 * kGib;

#if defined(_WIN32)

uint64_t MemoryBytes() {
  MEMORYSTATUSEX memory{};
  memory.dwLength = sizeof memory;
  return GlobalMemoryStatusEx(&memory) != 0 ? memory.ullTotalPhys : 0;
}

#else

uint64_t MemoryBytes() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  return pages > 0 && page_bytes > 0
             ? static_cast<uint64_t>(pages) * static_cast<uint64_t>(page_bytes)
             : 0;
}

#endif

// Returns whether a word of a processor's name says nothing about the model.
bool IsFiller(std::string_view word) {
  return word == "r" || word == "tm" || word == "cpu" || word == "processor";
}

// Returns the words of `text` in lower case, joined by dashes, without fillers and without
// characters other than letters and digits. Drops the text after an @, the clock rate, which the
// model name implies.
std::string Dashed(std::string_view text) {
  std::string dashed;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty() && !IsFiller(word)) dashed += (dashed.empty() ? "" : "-") + word;
    word.clear();
  };
  for (const char character : text.substr(0, text.find('@'))) {
    const auto byte = static_cast<unsigned char>(character);
    if (byte < 0x80 && std::isalnum(byte) != 0)
      word += static_cast<char>(std::tolower(byte));
    else
      end_word();
  }
  end_word();
  return dashed;
}

}  // namespace

std::string MachineClass() {
  std::string words = Dashed(ProcessorName());
  if (const unsigned threads = std::thread::hardware_concurrency(); threads > 0)
    words += "-" + std::to_string(threads);
  words += "-" + std::string(SimdTarget());
  const uint64_t steps = (MemoryBytes() + kMemoryStep - 1) / kMemoryStep;
  if (steps > 0) words += "-" + std::to_string(steps * kMemoryStep / kGib) + "g";
  return words;
}

}  // namespace sweepstake
