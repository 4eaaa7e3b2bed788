#include "engine_client/telemetry/common/validation.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/decider/options.h"
#include "engine_client/scene/utf8_path.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/text/names.h"

namespace sweepstake {
namespace {

bool IsPort(std::string_view text) {
  uint32_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= 65535;
}

bool IsHost(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return false;
  }
  return !host.empty() && host.size() <= 253 && std::all_of(host.begin(), host.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '-' || c == '_' || c == ':';
  });
}

Status Invalid(std::string_view option, std::string_view rule) {
  return {StatusCode::kInvalidArgument, std::string(option) + " must be " + std::string(rule)};
}

Status ValidateNames(const SessionOptions& options) {
  constexpr std::string_view kRule = "1 to 128 bytes of UTF-8 without control characters";
  constexpr std::string_view kOptionalRule =
      "at most 128 bytes of UTF-8 without control characters";
  if (!text::IsName(options.project)) return Invalid("project", kRule);
  if (!text::IsName(options.scene)) return Invalid("scene", kRule);
  if (!text::IsOptionalName(options.build)) return Invalid("build", kOptionalRule);
  if (!text::IsOptionalName(options.machine_class)) return Invalid("machine_class", kOptionalRule);
  if (!text::IsOptionalName(options.policy)) return Invalid("policy", kOptionalRule);
  return {};
}

Status ValidateBatching(const SessionOptions& options) {
  if (options.batch_interval_ms < 1 || options.batch_interval_ms > 10'000) {
    return Invalid("batch_interval_ms", "1 to 10000");
  }
  if (options.batch_frames < 1 || options.batch_frames > 240) {
    return Invalid("batch_frames", "1 to 240");
  }
  if (options.batch_bytes < 512 || options.batch_bytes > 256 * 1024) {
    return Invalid("batch_bytes", "512 to 262144");
  }
  return {};
}

bool IsPath(std::string_view path) {
  constexpr size_t kMaxPathBytes = 4096;
  return path.size() <= kMaxPathBytes && path.find('\0') == std::string_view::npos;
}

Status ValidateFlightRecorder(const FlightRecorderOptions& options) {
  constexpr double kMaxBudgetMs = 60'000;
  if (options.memory_mb == 0) return {};
  if (options.memory_mb > 1024) return Invalid("flight_recorder.memory_mb", "0 to 1024");
  if (!(options.frame_budget_ms > 0 && options.frame_budget_ms <= kMaxBudgetMs)) {
    return Invalid("flight_recorder.frame_budget_ms", "over 0 and at most 60000");
  }
  const std::optional<std::filesystem::path> folder = PathOfUtf8(options.directory);
  std::error_code error;
  if (folder && std::filesystem::is_directory(*folder, error)) return {};
  return Invalid("flight_recorder.directory", "an existing folder: create it first");
}

}  // namespace

Status ValidateDaemonAddress(std::string_view address) {
  const size_t colon = address.rfind(':');
  if (colon != std::string_view::npos && IsHost(address.substr(0, colon)) &&
      IsPort(address.substr(colon + 1))) {
    return {};
  }
  return {StatusCode::kInvalidArgument,
          "'" + std::string(address.substr(0, 300)) +
              "' is not an address; write HOST:PORT, such as 127.0.0.1:7433"};
}

Status ValidateTlsOptions(const TlsOptions& options, const TlsNames& names) {
  const std::string pair = names.cert + " and " + names.key;
  if (!IsPath(options.ca_file) || !IsPath(options.cert_file) || !IsPath(options.key_file)) {
    return Invalid(names.ca + ", " + pair, "paths of at most 4096 bytes");
  }
  if (options.cert_file.empty() != options.key_file.empty()) {
    return Invalid(pair, "set together or not at all");
  }
  if (!options.server_name.empty() && !IsHost(options.server_name)) {
    return Invalid(names.server_name, "a host name of at most 253 bytes");
  }
  return {};
}

Status ValidateSessionOptions(const SessionOptions& options, const TlsNames& names) {
  const FloatEnvironmentScope environment;
  if (Status status = ValidateNames(options); !status.ok()) return status;
  if (Status status = ValidateBatching(options); !status.ok()) return status;
  if (!(options.time_scale >= 1 && options.time_scale <= 1000)) {
    return Invalid("time_scale", "1 to 1000");
  }
  const std::vector<std::string> problems =
      decision::NumberProblems(decision::DecisionOptions().With(options.rules));
  if (!problems.empty()) return {StatusCode::kInvalidArgument, problems.front()};
  if (options.queue_frames < 2 || options.queue_frames > SampleQueue::kMaxFrameCapacity ||
      !std::has_single_bit(options.queue_frames)) {
    return Invalid("queue_frames", "a power of two, 2 to 1048576");
  }
  if (options.unacknowledged_messages < 1 || options.unacknowledged_messages > 4096) {
    return Invalid("unacknowledged_messages", "1 to 4096");
  }
  if (options.backoff_min_ms < 1 || options.backoff_max_ms < options.backoff_min_ms ||
      options.backoff_max_ms > 3'600'000) {
    return Invalid("backoff_min_ms and backoff_max_ms", "1 to 3600000, with min at most max");
  }
  if (Status status = ValidateFlightRecorder(options.flight_recorder); !status.ok()) return status;
  return options.tls ? ValidateTlsOptions(*options.tls, names) : Status();
}

}  // namespace sweepstake
