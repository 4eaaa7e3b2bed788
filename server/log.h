// The daemon's log: JSON lines on stderr. Thread-safe.
#pragma once

#include <memory>
#include <string>

namespace spdlog {
class logger;
}

namespace sweepstake::server {

// `level` as in Config::log_level. Each line has time (UTC), level and message.
std::shared_ptr<spdlog::logger> MakeLog(const std::string& level);

}  // namespace sweepstake::server
