#include "engine_client/telemetry/validation.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <string>

#include "engine_client/telemetry/sample_queue.h"

namespace sweepstake {
namespace {

// Returns the length in bytes of the UTF-8 sequence that begins with `lead`; 0 if no sequence
// begins with it.
size_t SequenceLength(uint8_t lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  if (lead >= 0xF0 && lead < 0xF5) return 4;
  return 0;
}

// Returns false for overlong forms, surrogates, code points above U+10FFFF, and control characters.
bool IsPrintable(uint32_t code_point, size_t length) {
  constexpr uint32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code_point < kMin[length] || code_point > 0x10FFFF) return false;
  if (code_point >= 0xD800 && code_point < 0xE000) return false;
  return code_point >= 0x20 && (code_point < 0x7F || code_point >= 0xA0);
}

// Consumes one printable character; returns false if there is none.
bool TakeCharacter(std::string_view& text) {
  const auto lead = static_cast<uint8_t>(text.front());
  const size_t length = SequenceLength(lead);
  if (length == 0 || length > text.size()) return false;
  uint32_t code_point = length == 1 ? lead : lead & (0x7FU >> length);
  for (size_t i = 1; i < length; ++i) {
    const auto next = static_cast<uint8_t>(text[i]);
    if ((next & 0xC0) != 0x80) return false;
    code_point = code_point << 6 | (next & 0x3F);
  }
  text.remove_prefix(length);
  return IsPrintable(code_point, length);
}

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
  if (options.project.empty() || !IsName(options.project)) return Invalid("project", kRule);
  if (options.scene.empty() || !IsName(options.scene)) return Invalid("scene", kRule);
  if (!IsName(options.build)) return Invalid("build", kOptionalRule);
  if (!IsName(options.machine_class)) return Invalid("machine_class", kOptionalRule);
  if (!IsName(options.policy)) return Invalid("policy", kOptionalRule);
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

}  // namespace

bool IsName(std::string_view text) {
  if (text.size() > kNameBytesMax) return false;
  while (!text.empty()) {
    if (!TakeCharacter(text)) return false;
  }
  return true;
}

Status ValidateDaemonAddress(std::string_view address) {
  const size_t colon = address.rfind(':');
  if (colon != std::string_view::npos && IsHost(address.substr(0, colon)) &&
      IsPort(address.substr(colon + 1))) {
    return {};
  }
  return {StatusCode::kInvalidArgument,
          "'" + std::string(address.substr(0, 300)) +
              "' is not an address; write HOST:PORT, as 127.0.0.1:7433"};
}

Status ValidateSessionOptions(const SessionOptions& options) {
  if (Status status = ValidateNames(options); !status.ok()) return status;
  if (Status status = ValidateBatching(options); !status.ok()) return status;
  if (!(options.time_scale >= 1 && options.time_scale <= 1000)) {
    return Invalid("time_scale", "1 to 1000");
  }
  if (options.queue_frames < 2 || options.queue_frames > SampleQueue::kFrameCapacityMax ||
      !std::has_single_bit(options.queue_frames)) {
    return Invalid("queue_frames", "a power of two, 2 to 1048576");
  }
  if (options.unacknowledged_messages < 1 || options.unacknowledged_messages > 4096) {
    return Invalid("unacknowledged_messages", "1 to 4096");
  }
  if (options.backoff_min_ms < 1 || options.backoff_max_ms < options.backoff_min_ms ||
      options.backoff_max_ms > 3'600'000) {
    return Invalid("backoff_min_ms and backoff_max_ms", "1 <= min <= max <= 3600000");
  }
  return {};
}

}  // namespace sweepstake
