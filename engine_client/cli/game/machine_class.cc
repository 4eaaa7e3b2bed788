#include "engine_client/cli/game/machine_class.h"

#include <sys/utsname.h>

#include <algorithm>
#include <cctype>
#include <thread>

namespace sweepstake::cli {

std::string MachineClass() {
  utsname names{};
  if (uname(&names) != 0) return "";
  std::string name = std::string(names.sysname) + "-" + names.machine + "-" +
                     std::to_string(std::thread::hardware_concurrency());
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char character) { return std::tolower(character); });
  return name;
}

}  // namespace sweepstake::cli
