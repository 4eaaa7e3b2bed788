#include "tests/laboratory/game/machine.h"

#include <hwy/highway.h>
#include <sys/utsname.h>

#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine_client/broad_phase/host/processor_name.h"
#include "sweepstake/simd.h"

namespace sweepstake::cli {
namespace {

std::string DateUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  char text[32] = "";
  if (gmtime_r(&now, &parts) != nullptr) {
    (void)std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  }
  return text;
}

std::string SystemName() {
  utsname names{};
  if (uname(&names) != 0) return "unknown";
  return std::string(names.sysname) + " " + names.release + " " + names.machine;
}

std::string CompilerName() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "gcc " __VERSION__;
#else
  return "unknown";
#endif
}

}  // namespace

Machine DescribeMachine() {
  Machine machine;
  machine.date_utc = DateUtc();
  machine.program = SWEEPSTAKE_VERSION;
  machine.cpu = ProcessorName();
  machine.core_count = std::thread::hardware_concurrency();
  machine.system = SystemName();
  machine.compiler = CompilerName();
  machine.simd_target = SimdTarget();
  machine.libraries.push_back({"Highway", std::to_string(HWY_MAJOR) + "." +
                                              std::to_string(HWY_MINOR) + "." +
                                              std::to_string(HWY_PATCH)});
  return machine;
}

nlohmann::ordered_json MachineJson(const Machine& machine) {
  auto libraries = nlohmann::ordered_json::object();
  for (const LibraryVersion& library : machine.libraries) libraries[library.name] = library.version;
  return {{"date", machine.date_utc},
          {"program", machine.program},
          {"cpu", machine.cpu},
          {"cores", machine.core_count},
          {"system", machine.system},
          {"compiler", machine.compiler},
          {"simd", machine.simd_target},
          {"libraries", libraries},
          {"absent_peers", machine.absent_peers}};
}

}  // namespace sweepstake::cli
