#include "engine_client/cli/trace/costs_file.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include "engine_client/cli/io/whole_file.h"
#include "engine_client/cli/trace/costs_message.h"
#include "server/decision/math/hash.h"

namespace sweepstake::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "SWPCOSTS";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderBytes = 32;

void AppendNumber(uint64_t number, size_t byte_count, std::string& bytes) {
  for (size_t i = 0; i < byte_count; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFFU);
}

uint64_t NumberAt(std::string_view bytes, size_t at, size_t byte_count) {
  uint64_t number = 0;
  for (size_t i = 0; i < byte_count; ++i) {
    number |= uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  }
  return number;
}

std::string Header(std::string_view payload) {
  std::string header(kMagic);
  AppendNumber(kVersion, 4, header);
  AppendNumber(0, 4, header);
  AppendNumber(payload.size(), 8, header);
  AppendNumber(math::Fnv1a(math::kFnv1aStart, payload), 8, header);
  return header;
}

Status Broken(const fs::path& path, const std::string& flaw) {
  return {StatusCode::kDataLoss,
          path.string() + " " + flaw + "; make it again with `sweepstake trace`"};
}

Result<std::string> ReadBytes(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return Status(StatusCode::kNotFound,
                  "there is no file " + path.string() + "; `sweepstake trace` makes .costs files");
  }
  const uint64_t size = fs::file_size(path, error);
  if (error || size > kHeaderBytes + kMostCostsBytes) {
    return Broken(path, "is larger than a cost trace may be");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file) return Broken(path, "could not be read");
  return bytes;
}

// What is wrong with the frame around the message, or nothing.
std::string FlawOfHeader(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with(kMagic)) return "is no cost trace";
  const uint64_t version = NumberAt(bytes, 8, 4);
  if (version != kVersion) {
    return "has version " + std::to_string(version) + ", and this program reads " +
           std::to_string(kVersion);
  }
  const std::string_view payload = bytes.substr(kHeaderBytes);
  const uint64_t size = NumberAt(bytes, 16, 8);
  if (NumberAt(bytes, 12, 4) != 0 || size != payload.size()) {
    return "is cut short or has bytes too many: " + std::to_string(payload.size()) +
           " in place of " + std::to_string(size);
  }
  return NumberAt(bytes, 24, 8) == math::Fnv1a(math::kFnv1aStart, payload)
             ? ""
             : "is damaged: its checksum does not fit";
}

}  // namespace

Status WriteCosts(const fs::path& path, const CostTrace& trace) {
  assert(FlawOf(trace).empty());
  const std::string payload = ToProto(trace).SerializeAsString();
  if (payload.size() > kMostCostsBytes) {
    return {StatusCode::kResourceExhausted,
            path.string() + " would be larger than a cost trace may be; trace fewer frames"};
  }
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(Header(payload));
  (*file)->Write(payload);
  return (*file)->Commit();
}

Result<CostTrace> ReadCosts(const fs::path& path) {
  const auto bytes = ReadBytes(path);
  if (!bytes.ok()) return bytes.status();
  if (const std::string flaw = FlawOfHeader(*bytes); !flaw.empty()) return Broken(path, flaw);
  const std::string_view payload = std::string_view(*bytes).substr(kHeaderBytes);
  costs::CostTrace message;
  if (!message.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    return Broken(path, "holds no readable message");
  }
  CostTrace trace = FromProto(message);
  if (const std::string flaw = FlawOf(trace); !flaw.empty()) return Broken(path, flaw);
  return trace;
}

}  // namespace sweepstake::cli
