#include "engine_client/scene/recorded_scene.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <system_error>

#include "engine_client/scene/utf8_path.h"

namespace sweepstake {
namespace {

namespace fs = std::filesystem;

Status Broken(std::string message) { return {StatusCode::kDataLoss, std::move(message)}; }

Status InFile(const fs::path& path, const Status& status) {
  return {status.code(), PathText(path) + ": " + status.message()};
}

bool ReadExactly(std::ifstream& file, std::span<std::byte> bytes) {
  const auto size = static_cast<std::streamsize>(bytes.size());
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  return file.gcount() == size;
}

// Returns the size of a regular file. Anything else is an error: a directory or a pipe can be
// opened, but reading it would fail or block.
Result<uint64_t> SizeOfRegularFile(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return Status(StatusCode::kNotFound, "no such file");
  if (!fs::is_regular_file(status)) return Broken("not a regular file");
  const uint64_t bytes = fs::file_size(path, error);
  if (error) return Broken("its size cannot be read: " + error.message());
  return bytes;
}

Status WrongSize(uint64_t file_bytes, const std::string& expected) {
  return Broken("has " + std::to_string(file_bytes) + " bytes, but its header requires " +
                expected);
}

}  // namespace

Result<std::unique_ptr<Scene>> RecordedScene::Open(const fs::path& path) {
  auto scene = OpenFile(path);
  if (!scene.ok()) return scene.status();
  return std::unique_ptr<Scene>(std::move(*scene));
}

Result<std::string> RecordedScene::NotesOf(const fs::path& path) {
  const auto scene = OpenFile(path);
  if (!scene.ok()) return scene.status();
  RecordedScene& file = **scene;
  std::string notes(static_cast<size_t>(file.header_.notes_bytes), '\0');
  file.file_.seekg(-static_cast<std::streamoff>(notes.size()), std::ios::end);
  if (!ReadExactly(file.file_, std::as_writable_bytes(std::span(notes))))
    return InFile(path, Broken("the notes cannot be read"));
  return notes;
}

Result<std::unique_ptr<RecordedScene>> RecordedScene::OpenFile(const fs::path& path) {
  const Result<uint64_t> file_bytes = SizeOfRegularFile(path);
  if (!file_bytes.ok()) return InFile(path, file_bytes.status());
  std::unique_ptr<RecordedScene> scene(new RecordedScene);
  Status status = scene->ReadHeader(path);
  if (status.ok()) status = scene->CheckNotes(*file_bytes);
  const auto notes_bytes = static_cast<uint64_t>(scene->header_.notes_bytes);
  if (status.ok()) status = scene->CheckSize(*file_bytes - notes_bytes);
  if (status.ok()) status = scene->CheckBoxes();
  if (!status.ok()) return InFile(path, status);
  return scene;
}

Status RecordedScene::ReadHeader(const fs::path& path) {
  file_.open(path, std::ios::binary);
  if (!file_) return {StatusCode::kNotFound, "cannot be opened for reading"};
  aabbs::HeaderBytes bytes;
  if (!ReadExactly(file_, bytes)) return Broken("is shorter than the 304 bytes of a .aabbs header");
  Result<aabbs::Header> header = aabbs::DecodeHeader(bytes);
  if (!header.ok()) return header.status();
  header_ = std::move(*header);
  if (header_.scene_name.empty()) header_.scene_name = "recorded";
  return {};
}

Status RecordedScene::CheckNotes(uint64_t file_bytes) const {
  const auto notes_bytes = static_cast<uint64_t>(header_.notes_bytes);
  if (file_bytes - aabbs::kHeaderBytes >= notes_bytes) return {};
  return Broken("is shorter than the " + std::to_string(notes_bytes) +
                " bytes of notes that its header names");
}

// Compares the file's size with the counts in the header, and only then allocates memory.
Status RecordedScene::CheckSize(uint64_t file_bytes) {
  if (header_.layout == aabbs::Layout::kChangingCount) {
    if (Status status = ReadCountTable(file_bytes); !status.ok()) return status;
  } else {
    const uint64_t payload = file_bytes - aabbs::kHeaderBytes;
    const uint64_t frame_bytes = uint64_t{aabbs::kBoxBytes} * CountOf(0);
    if (payload % frame_bytes != 0 || payload / frame_bytes != header_.frames_with_spawn()) {
      return WrongSize(file_bytes, "304 + (1 + " + std::to_string(header_.frame_count) + ") * " +
                                       std::to_string(header_.object_count) + " * 32");
    }
  }
  const auto largest = static_cast<uint32_t>(header_.object_count);
  if (largest > kMaxSceneObjectCount) {
    return {StatusCode::kResourceExhausted,
            "has " + std::to_string(largest) + " objects, but at most " +
                std::to_string(kMaxSceneObjectCount) + " are supported"};
  }
  boxes_.resize(largest);
  bytes_.resize(size_t{largest} * aabbs::kBoxBytes);
  return {};
}

Status RecordedScene::ReadCountTable(uint64_t file_bytes) {
  const uint64_t frames = header_.frames_with_spawn();
  const uint64_t payload = file_bytes - aabbs::kHeaderBytes;
  const std::string table = std::to_string(frames) + " counts of 4 bytes";
  if (payload / aabbs::kCountBytes < frames) return WrongSize(file_bytes, "304 + boxes + " + table);
  const uint64_t box_bytes = payload - frames * aabbs::kCountBytes;
  file_.seekg(static_cast<std::streamoff>(aabbs::kHeaderBytes + box_bytes));
  counts_.reserve(frames);
  std::array<std::byte, aabbs::kCountBytes> bytes;
  for (uint64_t frame = 0; frame < frames; ++frame) {
    if (!ReadExactly(file_, bytes)) return Broken("the count table cannot be read");
    const int32_t count = aabbs::DecodeInt32(bytes);
    if (count < 0 || count > header_.object_count) {
      return Broken("frame " + std::to_string(frame) + " has " + std::to_string(count) +
                    " objects, but must have 0 to " + std::to_string(header_.object_count));
    }
    counts_.push_back(static_cast<uint32_t>(count));
  }
  const uint64_t boxes = std::accumulate(counts_.begin(), counts_.end(), uint64_t{0});
  if (box_bytes % aabbs::kBoxBytes != 0 || box_bytes / aabbs::kBoxBytes != boxes) {
    return WrongSize(file_bytes, "304 + " + std::to_string(boxes) + " * 32 + " + table);
  }
  if (*std::max_element(counts_.begin(), counts_.end()) !=
      static_cast<uint32_t>(header_.object_count)) {
    return Broken("no frame has the " + std::to_string(header_.object_count) +
                  " objects that the header names as the largest count");
  }
  return {};
}

Status RecordedScene::CheckBoxes() {
  Rewind();
  for (uint64_t frame = 0; frame < header_.frames_with_spawn(); ++frame) {
    if (!ReadNextFrame()) return Broken("frame " + std::to_string(frame) + " cannot be read");
    if (Status status = CheckFrame(frame); !status.ok()) return status;
  }
  Rewind();
  if (!ReadNextFrame()) return Broken("frame 0 cannot be read");
  return {};
}

Status RecordedScene::CheckFrame(uint64_t file_frame) const {
  const std::span<const Aabb> boxes = aabbs();
  const auto bad = std::find_if_not(boxes.begin(), boxes.end(), aabbs::IsFinite);
  if (bad == boxes.end()) return {};
  return Broken("frame " + std::to_string(file_frame) + ", object " +
                std::to_string(bad - boxes.begin()) + " has a coordinate that is not finite");
}

void RecordedScene::DoStep() {
  ++frame_index_;
  if (next_file_frame_ == header_.frames_with_spawn()) Rewind();
  if (!ReadNextFrame()) Rewind();
}

bool RecordedScene::ReadNextFrame() {
  if (!ReadBoxes(CountOf(next_file_frame_))) return false;
  ++next_file_frame_;
  return true;
}

bool RecordedScene::ReadBoxes(size_t count) {
  const std::span<std::byte> frame = std::span(bytes_).first(count * aabbs::kBoxBytes);
  if (!ReadExactly(file_, frame)) return false;
  for (size_t i = 0; i < count; ++i) {
    boxes_[i] = aabbs::DecodeBox(
        std::span<const std::byte>(frame).subspan(i * aabbs::kBoxBytes).first<aabbs::kBoxBytes>());
  }
  shown_count_ = count;
  return true;
}

void RecordedScene::Rewind() {
  file_.clear();
  file_.seekg(aabbs::kHeaderBytes);
  next_file_frame_ = 0;
}

size_t RecordedScene::CountOf(uint64_t file_frame) const {
  return counts_.empty() ? static_cast<size_t>(header_.object_count) : counts_[file_frame];
}

}  // namespace sweepstake
