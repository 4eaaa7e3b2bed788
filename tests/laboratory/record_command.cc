// `sweepstake-lab record`: writes a scene's frames into a .aabbs file.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/json_output.h"
#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

struct RecordOptions {
  SceneChoice scene{"", 1000, 1};
  uint64_t frames = 0;
  std::string out;
  bool json = false;
};

// Shows the progress of a recording and counts the objects of the frame with the most objects. The
// recorder calls Step once per frame.
class ObservedScene : public Scene {
 public:
  ObservedScene(Scene& scene, Progress& progress)
      : scene_(scene), progress_(progress), max_objects_(scene.aabbs().size()) {}

  std::string_view name() const override { return scene_.name(); }
  Aabb world() const override { return scene_.world(); }
  uint64_t frame_index() const override { return scene_.frame_index(); }
  std::span<const Aabb> aabbs() const override { return scene_.aabbs(); }
  size_t max_object_count() const override { return scene_.max_object_count(); }
  void DoStep() override {
    scene_.Step();
    max_objects_ = std::max(max_objects_, scene_.aabbs().size());
    progress_.Show(++steps_);
  }
  size_t max_objects() const { return max_objects_; }

 private:
  Scene& scene_;
  Progress& progress_;
  uint64_t steps_ = 0;
  size_t max_objects_;
};

int MakeRecording(const RecordOptions& options, Terminal& terminal) {
  auto scene = OpenScene(options.scene);
  if (!scene.ok()) return Fail(terminal, scene.status());
  size_t max_objects = 0;
  {
    Progress progress(terminal, "record", options.frames);
    ObservedScene observed(**scene, progress);
    const Status status = RecordScene(observed, options.frames, options.out);
    if (!status.ok()) return Fail(terminal, status);
    max_objects = observed.max_objects();
  }
  const auto bytes = std::filesystem::file_size(options.out);
  const nlohmann::ordered_json document = {{"command", "record"},
                                           {"scene", options.scene.name},
                                           {"objects", max_objects},
                                           {"seed", options.scene.seed},
                                           {"frames", options.frames},
                                           {"out", options.out},
                                           {"bytes", bytes}};
  PrintResult(terminal, options.json, document,
              options.out + ": " + std::to_string(options.frames + 1) + " frames of up to " +
                  std::to_string(max_objects) + " boxes, " + std::to_string(bytes) + " bytes\n");
  return kDone;
}

}  // namespace

void AddRecordCommand(const CommandContext& context) {
  AddCommand<RecordOptions>(
      context, "record", "Write a scene's boxes, frame by frame, as a .aabbs file",
      "  sweepstake-lab record --scene hurricane --objects 3000 --frames 600 --seed 1 --out "
      "h.aabbs\n"
      "The file contains the initial boxes and then --frames frames. It is written completely\n"
      "or not at all.\n" +
          SceneHelp(),
      [](CLI::App& command, RecordOptions& options) {
        AddSceneChoice(command, options.scene);
        command.add_option("--frames", options.frames, "Frames after the initial boxes")
            ->check(WholeUpTo(2'147'483'647))
            ->required();
        command.add_option("--out", options.out, "File to write")->required();
        AddJsonFlag(command, options.json);
      },
      MakeRecording);
}

}  // namespace sweepstake::cli
