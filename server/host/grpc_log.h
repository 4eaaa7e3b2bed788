// Writes gRPC's errors into the daemon's log. Its other lines are dropped: clients could cause any
// number of them.
#pragma once

#include <memory>

namespace spdlog {
class logger;
}

namespace sweepstake::server {

// Until this object is destroyed, at most one error in ten seconds is logged, with the number of
// omitted ones. Only one object may exist at a time. Thread-safe.
class GrpcLog {
 public:
  explicit GrpcLog(std::shared_ptr<spdlog::logger> log);
  ~GrpcLog();
  GrpcLog(const GrpcLog&) = delete;
  GrpcLog& operator=(const GrpcLog&) = delete;
};

}  // namespace sweepstake::server
