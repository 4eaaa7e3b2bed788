#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/scene/aabbs_format.h"
#include "engine_client/scene/utf8_path.h"
#include "engine_client/text/names.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

namespace fs = std::filesystem;

Status CannotWrite(const fs::path& path, const std::string& reason) {
  return {StatusCode::kUnavailable, PathText(path) + " cannot be written: " + reason};
}

std::string SystemReason() {
  return errno == 0 ? "unknown reason" : std::generic_category().message(errno);
}

// Returns a path in the target's folder, so that renaming it does not cross file systems. Its
// suffix is random, so that two recorders do not use the same file.
fs::path PartialPath(const fs::path& target) {
  std::random_device random;
  std::ostringstream suffix;
  suffix << ".partial-" << std::hex << random() << random();
  fs::path partial = target;
  partial += suffix.str();
  return partial;
}

// A file that gets its final name only when it is complete. If Commit is not called, the destructor
// removes the file.
class PendingFile {
 public:
  explicit PendingFile(const fs::path& target) : target_(target), partial_(PartialPath(target)) {
    errno = 0;
    file_.open(partial_, std::ios::binary | std::ios::trunc);
  }

  ~PendingFile() {
    if (committed_) return;
    file_.close();
    std::error_code ignored;
    fs::remove(partial_, ignored);
  }

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  void Append(std::span<const std::byte> bytes) {
    file_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  }

  void OverwriteStart(std::span<const std::byte> bytes) {
    file_.seekp(0);
    Append(bytes);
  }

  Status status() const { return file_ ? Status() : CannotWrite(target_, SystemReason()); }

  Status Commit() {
    file_.close();
    if (!file_) return status();
    std::error_code error;
    fs::rename(partial_, target_, error);
    if (error) return CannotWrite(target_, error.message());
    committed_ = true;
    return {};
  }

 private:
  const fs::path target_;
  const fs::path partial_;
  std::ofstream file_;
  bool committed_ = false;
};

class FrameWriter {
 public:
  explicit FrameWriter(PendingFile& file) : file_(file) { file_.Append(aabbs::HeaderBytes{}); }

  Status Append(std::span<const Aabb> boxes) {
    bytes_.resize(boxes.size() * aabbs::kBoxBytes);
    const std::span<std::byte> bytes(bytes_);
    for (size_t i = 0; i < boxes.size(); ++i) {
      if (!aabbs::IsFinite(boxes[i])) return NotFinite(i);
      aabbs::EncodeBox(boxes[i], bytes.subspan(i * aabbs::kBoxBytes).first<aabbs::kBoxBytes>());
    }
    file_.Append(bytes);
    counts_.push_back(static_cast<uint32_t>(boxes.size()));
    return file_.status();
  }

  // Appends the count table, if the count changed, and the notes. Then overwrites the header,
  // because its fields are known only now.
  Status Finish(const Scene& scene, std::string_view notes) {
    aabbs::Header header;
    header.notes_bytes = static_cast<int32_t>(notes.size());
    header.scene_name = scene.name();
    header.world = scene.world();
    header.frame_count = static_cast<int32_t>(counts_.size() - 1);
    const auto [min, max] = std::minmax_element(counts_.begin(), counts_.end());
    if (*max == 0 || *max > kMaxSceneObjectCount) return BadCount(*max);
    header.object_count = static_cast<int32_t>(*max);
    if (*min != *max) {
      header.layout = aabbs::Layout::kChangingCount;
      AppendCountTable();
    }
    file_.Append(std::as_bytes(std::span(notes.data(), notes.size())));
    file_.OverwriteStart(aabbs::EncodeHeader(header));
    return file_.status();
  }

 private:
  Status NotFinite(size_t object) const {
    return {StatusCode::kInvalidArgument,
            "frame " + std::to_string(counts_.size()) + ", object " + std::to_string(object) +
                " has a coordinate that is not finite and cannot be recorded"};
  }

  static Status BadCount(uint32_t max) {
    return {StatusCode::kInvalidArgument,
            "a recording needs from 1 to " + std::to_string(kMaxSceneObjectCount) +
                " objects in its largest frame, but the scene has " + std::to_string(max)};
  }

  void AppendCountTable() {
    std::array<std::byte, aabbs::kCountBytes> bytes;
    for (const uint32_t count : counts_) {
      aabbs::EncodeInt32(static_cast<int32_t>(count), bytes);
      file_.Append(bytes);
    }
  }

  PendingFile& file_;
  std::vector<uint32_t> counts_;
  std::vector<std::byte> bytes_;
};

Status CheckTarget(uint64_t frame_count, const fs::path& path) {
  constexpr uint64_t kMaxFrameCount = std::numeric_limits<int32_t>::max();
  if (frame_count > kMaxFrameCount) {
    return {StatusCode::kInvalidArgument, "a recording takes at most " +
                                              std::to_string(kMaxFrameCount) + " frames, not " +
                                              std::to_string(frame_count)};
  }
  if (!path.has_filename()) {
    return {StatusCode::kInvalidArgument, "'" + PathText(path) + "' is not a file name"};
  }
  std::error_code error;
  const fs::path directory = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(directory, error)) {
    return {StatusCode::kNotFound,
            text::PrintableLine(directory.string()) + " is not a directory: create it first"};
  }
  if (fs::exists(path, error) && !fs::is_regular_file(path, error))
    return CannotWrite(path, "it is not a file; give the path of a file");
  return {};
}

}  // namespace

Status RecordScene(Scene& scene, uint64_t frame_count, std::string_view path,
                   std::string_view notes) {
  const FloatEnvironmentScope environment;
  const std::optional<fs::path> target = PathOfUtf8(path);
  if (!target) {
    return {StatusCode::kInvalidArgument, "'" + text::PrintableLine(path) + "' is not UTF-8"};
  }
  if (notes.size() > aabbs::kMaxNotesBytes) {
    return {StatusCode::kInvalidArgument, "notes take at most " +
                                              std::to_string(aabbs::kMaxNotesBytes) +
                                              " bytes, not " + std::to_string(notes.size())};
  }
  if (Status status = CheckTarget(frame_count, *target); !status.ok()) return status;
  PendingFile file(*target);
  if (Status status = file.status(); !status.ok()) return status;
  FrameWriter writer(file);
  Status status = writer.Append(scene.aabbs());
  for (uint64_t frame = 0; status.ok() && frame < frame_count; ++frame) {
    scene.Step();
    status = writer.Append(scene.aabbs());
  }
  if (status.ok()) status = writer.Finish(scene, notes);
  if (status.ok()) status = file.Commit();
  return status;
}

}  // namespace sweepstake
