#include "server/host/grpc_log.h"

#include <grpc/support/log.h>
#include <spdlog/logger.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace sweepstake::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kInterval{10};

// gRPC's log function has no argument for an object.
struct Target {
  std::mutex mutex;
  std::shared_ptr<spdlog::logger> log;  // null: lines are dropped
  std::optional<Clock::time_point> latest;
  uint64_t omitted_count = 0;
};

Target& TheTarget() {
  static Target target;
  return target;
}

void Write(gpr_log_func_args* line) {
  if (line->severity != GPR_LOG_SEVERITY_ERROR) return;
  Target& target = TheTarget();
  const std::lock_guard lock(target.mutex);
  const Clock::time_point now = Clock::now();
  if (!target.log || (target.latest && now - *target.latest < kInterval)) {
    ++target.omitted_count;
    return;
  }
  target.latest = now;
  target.log->warn("gRPC: {} ({} lines before it were omitted)", line->message,
                   std::exchange(target.omitted_count, 0));
}

void SetTarget(std::shared_ptr<spdlog::logger> log) {
  Target& target = TheTarget();
  const std::lock_guard lock(target.mutex);
  target.log = std::move(log);
  target.latest.reset();
  target.omitted_count = 0;
}

}  // namespace

GrpcLog::GrpcLog(std::shared_ptr<spdlog::logger> log) {
  SetTarget(std::move(log));
  gpr_set_log_function(Write);
}

GrpcLog::~GrpcLog() { SetTarget(nullptr); }

}  // namespace sweepstake::server
