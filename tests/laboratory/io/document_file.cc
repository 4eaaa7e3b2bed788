#include "tests/laboratory/io/document_file.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine_client/cli/io/whole_file.h"

namespace sweepstake::cli {

Status WriteDocument(const std::filesystem::path& path, const DocumentFormat& format,
                     const nlohmann::ordered_json& content) {
  nlohmann::ordered_json document = {{"format", format.name}, {"version", format.version}};
  document.update(content);
  std::string bytes;
  if (format.is_cbor) {
    nlohmann::ordered_json::to_cbor(document, bytes);
  } else {
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    bytes = document.dump(format.is_indented ? 2 : -1, ' ', false, kReplace) + "\n";
  }
  return WriteWhole(path, bytes);
}

Status ReadDocument(const std::filesystem::path& path, const DocumentFormat& format,
                    const std::function<std::string(const nlohmann::json&)>& take) {
  std::error_code unknown;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, unknown)) {
    return {StatusCode::kNotFound,
            "there is no " + std::string(format.kind) + " at " + path.string() + format.remedy};
  }
  std::string error;
  try {
    const nlohmann::json document =
        format.is_cbor ? nlohmann::json::from_cbor(file) : nlohmann::json::parse(file);
    error = document.at("format") == format.name && document.at("version") == format.version
                ? take(document)
                : "its format or version is not supported";
  } catch (const nlohmann::json::exception& exception) {
    error = exception.what();
  }
  if (error.empty()) return {};
  return {StatusCode::kDataLoss,
          path.string() + " is not a valid " + format.kind + ": " + error + format.remedy};
}

}  // namespace sweepstake::cli
